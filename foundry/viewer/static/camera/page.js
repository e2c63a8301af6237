"use strict";
/* What shows 3D runs: the scene beside the very image the model saw, its reply and what was understood. */
(function (foundry) {
  const {h, fill, badge, quote, number} = foundry.dom;

  const AGAIN_MS = 500;
  const LISTED = 8;

  function pose(value) {
    return `x ${number(value.x)} m, y ${number(value.y)} m, z ${number(value.z)} m, yaw ${number(value.yaw)}°, pitch ${number(value.pitch)}°`;
  }

  function command(value) {
    const parts = [];
    if (value.translate) parts.push(`translate ${number(value.translate.distance)} m towards ${number(value.translate.bearing)}°`);
    if (value.turn !== null && value.turn !== undefined) parts.push(`turn ${number(value.turn)}°`);
    if (value.gaze !== null && value.gaze !== undefined) parts.push(`gaze ${number(value.gaze)}°`);
    if (value.stay) parts.push("stay");
    if (value.answer !== null && value.answer !== undefined) parts.push(`answer ${value.answer}`);
    return parts.join(", ") || "nothing";
  }

  function metres(value) { return value === null ? "cannot be reached" : `${number(value)} m`; }

  /** The scene of a run; takes up new records while the run grows. */
  class Scene {
    constructor(data) {
      this.data = data;
      this.box = h("div", {class: "scene"});
      this.note = h("p", {class: "note"});
      this.element = h("figure", {class: "scene-box"}, this.box, h("figcaption", {}, this.note));
      this.steps = null;
    }

    /** Show these records; the scene itself is asked for once. */
    async show(steps) {
      const waiting = this.steps;
      this.steps = steps;
      if (this.mounted) this.mounted.update(steps);
      if (waiting) return;
      try {
        await foundry.script("camera/scene3d.js");
        const glb = await this.load();
        if (this.disposed) return;
        const mounted = await window.FoundryScene.mount(this.box, {glb, episode: this.data.about.episode, steps: this.steps});
        if (this.disposed) { mounted.dispose(); return; }
        this.mounted = mounted;
        mounted.update(this.steps);
        this.seek(this.wanted || 0);
      } catch (error) {
        this.note.textContent = `The scene cannot be shown: ${error.message}`;
      }
    }

    async load() {
      this.note.textContent = "The scene is being prepared\u2026";
      try {
        const bytes = await foundry.source.bytes(`${this.data.address}/scene`);
        this.note.textContent = "The way of the camera; drag to turn";
        return bytes.byteLength ? bytes : null;
      } catch (error) {
        this.note.textContent = `The way alone, without the scene: ${error.message}`;
        return null;
      }
    }

    /** Show the pose after so many decisions. */
    seek(decisions) {
      this.wanted = decisions;
      if (this.mounted) this.mounted.seek(decisions);
    }

    dispose() {
      this.disposed = true;
      if (this.mounted) this.mounted.dispose();
    }
  }

  /** The image the model saw at a step, or the word that it was not kept. */
  class SeenImage {
    constructor(data) {
      this.data = data;
      this.image = h("img", {alt: "", class: "seen", onerror: () => this.again()});
      this.none = h("p", {class: "note"}, "The image of this step was not kept.");
      this.walk = h("div", {class: "walk"});
      this.element = h("figure", {class: "seen-box"}, this.image, this.none, this.walk, h("figcaption", {}, "What the model saw"));
    }

    /** Show the image of a step as soon as its record is there; returns whether it is. */
    draw(step) {
      const chunk = step ? this.data.chunkAt(step) : null;
      if (chunk) this.show(chunk.steps[step - chunk.first]);
      return chunk !== null;
    }

    select() {}

    label(name) { this.image.alt = this.about ? `${this.about} (${name})` : ""; }

    show(record) {
      const path = record && record.image;
      this.image.hidden = !path;
      this.none.hidden = Boolean(path);
      this.showWalk(record?.frames || []);
      if (!path) return;
      const url = this.address(path);
      if (this.url !== url) this.image.setAttribute("src", url);
      this.url = url;
      this.about = `The image the model saw at step ${record.step}`;
      this.image.alt = this.about;
    }

    address(path) { return foundry.source.file(this.data.sweep, `${this.data.about.folder}/${path}`); }

    /** Show the pictures of a walk that went with a question, the earliest first; those that are shown already stay. */
    showWalk(paths) {
      if (this.shownWalk === paths.join()) return;
      this.shownWalk = paths.join();
      fill(this.walk, paths.map((path, at) => h("img", {src: this.address(path), alt: `Picture ${at + 1} of the walk`})));
    }

    /** Ask once more a little later: while a run is written, a record may be there before its image is. */
    again() {
      const {url} = this, src = this.image.getAttribute("src");
      if (src === url) setTimeout(() => { if (this.url === url) this.image.setAttribute("src", `${url}?again`); }, AGAIN_MS);
    }
  }

  /** A question after a walk, what there is to choose from, and the right answer. */
  function questionView(record) {
    if (!record.question) return null;
    const choices = Object.entries(record.choices).map(([label, text]) => h("li", {}, h("bdi", {}, `${label}: ${text}`)));
    return [
      h("h4", {}, `Question: ${record.kind}`),
      Object.values(record.question).map((text) => h("p", {class: "question"}, h("bdi", {}, text))),
      choices.length ? h("ul", {class: "told"}, choices) : null,
      foundry.parts.facts([["right answer", String(record.truth)], ["chance", record.chance === null ? "none" : number(record.chance)]]),
    ];
  }

  function decisionView({record}) {
    const seen = Object.entries(record.visible_px).sort((a, b) => b[1] - a[1]), more = seen.length - LISTED;
    return [
      foundry.parts.facts([["outcome", badge(record.outcome)], ["command", command(record.command)], ["boundary", record.boundary || "none"]]),
      questionView(record),
      h("h4", {}, "Reply"), quote(record.reply, "reply"),
      record.notes.length ? [h("h4", {}, "Notes of the reading"), h("ul", {class: "told"}, record.notes.map((note) => h("li", {}, h("bdi", {}, note))))] : null,
      foundry.parts.facts([
        ["travelled", metres(record.travelled)], ["to the goal", `${metres(record.distance_before)} → ${metres(record.distance_to_goal)}`],
        ["target in view", `${number(record.target_visible_px)} px${record.line_of_sight ? ", line of sight" : ""}`],
        ["reached", record.success ? "yes" : "no"], ["model took", `${number(record.inference_s)} s`],
        ["pose", pose(record.pose)], ["pose after", pose(record.pose_next)],
        ["in view", seen.slice(0, LISTED).map(([label, pixels]) => `${label} ${number(pixels)} px`).join(", ") + (more > 0 ? ` and ${more} more` : "")],
      ]),
    ];
  }

  class CameraPage {
    constructor(data, wanted) {
      this.data = data;
      this.scene = new Scene(data);
      this.image = new SeenImage(data);
      this.body = h("div", {class: "decision"});
      this.asked = h("div", {class: "decision"});
      this.opened = new Set();
      foundry.parts.keepOpen(this.asked, this.opened);
      this.player = new foundry.Player({marks: () => data.marks, ...data.form.player(),
        summary: () => this.summary(), onKey: (key) => key === "/" && (this.search.focus(), true)});
      this.clock = this.player.clock;
      this.search = new foundry.Search(data, "Search in replies", (step) => { this.clock.pause(); this.clock.seek(step); });
      this.clock.onChange(() => this.update());
      this.state = h("span", {class: "state"});
      this.element = h("div", {class: "run"}, foundry.runHeading(data, this.state), this.goal(), this.player.element,
        h("div", {class: "stage camera"}, h("div", {class: "views"}, this.scene.element, this.image.element),
          h("div", {class: "side"}, h("section", {class: "inspector", "aria-label": "Decision"}, this.body, h("h3", {}, "Prompts and replies"), this.asked), this.search.element)));
      data.onGrowth(() => this.grown());
      this.grown(wanted);
    }

    dispose() { this.disposed = true; this.player.dispose(); this.scene.dispose(); }

    goal() {
      const {episode} = this.data.about;
      if (!episode) return null;
      const told = Object.entries(episode.instruction || {});
      const goal = ["Find ", h("b", {}, h("bdi", {}, episode.target)),
        ` in ${episode.scene}; within ${number(episode.radius)} m counts as reached. Shortest way: ${metres(episode.shortest_m)}.`];
      return h("div", {class: "goal"}, h("p", {}, episode.walk ? `Questions after a walk in ${episode.scene}.` : goal),
      told.map(([language, text]) => h("p", {class: "told-way"}, `Told in ${language}: `, h("q", {}, h("bdi", {}, text)))));
    }

    summary() {
      const record = this.record;
      return record ? `${record.outcome}: ${command(record.command)}.` : "";
    }

    async grown(wanted) {
      foundry.showState(this.state, this.data);
      if (this.data.done && !this.data.about.episode) this.data.about = await foundry.source.json(`${this.data.address}/about`);
      this.clock.setSteps(this.data.done);
      this.player.showGrowing(!this.data.ended && foundry.source.live);
      if (wanted) this.player.begin(wanted.step, this.data.written);
      if (this.data.done) this.scene.show(await this.allSteps());
      await this.data.loadMarks(() => this.player.timeline.draw());
    }

    async allSteps() {
      const size = this.data.about.steps_per_chunk, steps = [];
      for (let first = 1; first <= this.data.done; first += size) steps.push(...(await this.data.load(first)).steps);
      return steps;
    }

    async update() {
      const {clock, data} = this;
      if (!clock.steps) return;
      const step = clock.step;
      this.scene.seek(clock.share < 1 ? step - 1 : step);
      if (!clock.playing) foundry.remember({step});
      if (this.step === step) return;
      this.step = step;
      try {
        const chunk = await data.load(step);
        if (this.step !== step) return;
        this.record = chunk.steps[step - chunk.first];
        this.image.show(this.record);
        fill(this.body, h("h3", {}, `Step ${step}`), decisionView({record: this.record}));
        const decision = await data.decision(step, this.record.agent);
        if (this.step === step) fill(this.asked, foundry.parts.calls(data, decision, this.opened));
      } catch (error) {
        fill(this.body, h("p", {class: "warning"}, error.message));
      }
    }
  }

  foundry.form("camera", {
    page: (data, wanted) => new CameraPage(data, wanted),
    panel: (data) => new SeenImage(data),
    chunk: (found) => found,
    same(chunk, about, step) {
      const record = chunk.steps[step - chunk.first];
      return JSON.stringify([record.pose, record.command, record.outcome]);
    },
    decision: decisionView,
    outcome: ({record}) => record?.outcome,
    words: {did: "action or position", said: "reply"},
    player: () => ({kinds: ["failure", "boundary"], signs: ["success"], fires: []}),
  });
})(window.Foundry);
