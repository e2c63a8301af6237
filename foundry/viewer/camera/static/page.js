"use strict";
/* The page for 3D runs: the image that the model saw next to the plan, or the scene; the reply and its reading. */
(function (foundry) {
  const {h, fill, badge, quote, number} = foundry.dom;

  const LISTED = 8;
  const KEYS = [["Tab to the scene, ← → ↑ ↓", "turn it"], ["there, + − Home", "zoom in, zoom out, show everything"], ["V", "switch between image with plan and whole scene"]];
  const TABS = ["Image and plan", "Whole scene"];

  function pose(value) {
    return `x ${number(value.x)} m, y ${number(value.y)} m, z ${number(value.z)} m, yaw ${number(value.yaw)}°, pitch ${number(value.pitch)}°`;
  }

  function metres(value) { return value === null ? "cannot be reached" : `${number(value)} m`; }

  /** The scene of a run. It shows new records while the run grows. */
  class Scene {
    constructor(data, camera) {
      this.data = data;
      this.camera = camera;
      this.box = h("div", {class: "scene"});
      this.note = h("p", {class: "note"});
      this.element = h("figure", {class: "scene-box"}, this.box, h("figcaption", {}, this.note));
      this.steps = null;
    }

    /** Show these records. The scene is loaded only once. */
    async show(steps) {
      const waiting = this.steps;
      this.steps = steps;
      if (this.mounted) this.mounted.update(steps);
      if (waiting) return;
      try {
        await foundry.script("camera/scene3d.js");
        const glb = await this.load();
        if (this.disposed) return;
        const mounted = await window.FoundryScene.mount(this.box, {
          glb, episode: this.data.about.episode, steps: this.steps, camera: this.camera, onCamera: (camera) => foundry.remember({camera})});
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
        this.note.textContent = "The route of the camera; drag to turn the view";
        return bytes.byteLength ? bytes : null;
      } catch (error) {
        this.note.textContent = `The path is shown without the scene: ${error.message}`;
        return null;
      }
    }

    /** Show the pose after a number of decisions. */
    seek(decisions) {
      this.wanted = decisions;
      if (this.mounted) this.mounted.seek(decisions);
    }

    dispose() {
      this.disposed = true;
      if (this.mounted) this.mounted.dispose();
    }
  }

  /** A question after a walk, with its options and the right answer. */
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
      foundry.parts.facts([["outcome", badge(record.outcome)], ["command", foundry.camera.command(record.command)], ["boundary", record.boundary || "none"]]),
      questionView(record),
      h("h4", {}, "Reply"), quote(record.reply, "reply"),
      record.notes.length ? [h("h4", {}, "Notes on how the reply was read"), h("ul", {class: "told"}, record.notes.map((note) => h("li", {}, h("bdi", {}, note))))] : null,
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
      this.agent = null;
      this.scene = new Scene(data, wanted.camera);
      this.image = new foundry.camera.SeenImage(data);
      this.plan = new foundry.Ways([data], {names: [data.about.model], looks: [foundry.looks.look(data.about.models.indexOf(data.about.model))]});
      this.body = h("div", {class: "decision"});
      this.asked = h("div", {class: "decision"});
      this.opened = new Set();
      foundry.parts.keepOpen(this.asked, this.opened);
      this.search = new foundry.Search(data, "Search in replies", (step) => { this.clock.pause(); this.clock.seek(step); });
      this.notes = foundry.notesOfRun(this);
      this.player = new foundry.Player({marks: () => data.marks, ...data.form.player(), ...data.happening(() => null), summary: () => this.summary(), search: this.search, notes: this.notes, keys: KEYS});
      this.clock = this.player.clock;
      this.clock.onChange(() => this.update());
      this.state = h("span", {class: "state"});
      const views = this.views(wanted.camera);
      this.element = h("div", {class: "run fits"}, foundry.runHeading(data, this.state), this.goal(), this.player.element,
        h("div", {class: "choices"}, h("div", {class: "tabs", role: "group", "aria-label": "Views"}, this.tabs.map((tab) => [tab, " "])), foundry.camera.marking([this.image])),
        h("div", {class: "stage camera"}, views,
          h("div", {class: "side"}, h("section", {class: "inspector", "aria-label": "Decision"}, h("h2", {class: "unseen"}, "Decision"), this.body, h("h3", {}, "Prompts and replies"), this.asked), this.notes.element, this.search.element)));
      data.onGrowth(() => this.grown());
      data.onAnalysis(() => this.player.redraw());
      this.grown(wanted);
    }

    dispose() {
      this.disposed = true;
      document.removeEventListener("keydown", this.onKeyDown);
      this.player.dispose();
      this.scene.dispose();
    }

    /** Shows either the image with the plan, or the scene. The scene is loaded when it is first shown. */
    views(camera) {
      const image = h("section", {class: "seen-side", "aria-label": "What the model saw"}, this.image.element);
      this.both = h("div", {class: "views"}, image, this.plan.box);
      this.tabs = TABS.map((name, index) => h("button", {type: "button", onclick: () => this.open(index)}, name));
      this.onKeyDown = (event) => { if (!foundry.dom.isTyping(event) && event.key.toLowerCase() === "v") this.open(1 - this.opened3d); };
      document.addEventListener("keydown", this.onKeyDown);
      this.open(camera ? 1 : 0);
      return h("div", {class: "main"}, this.both, this.scene.element);
    }

    open(index) {
      this.opened3d = index;
      this.tabs.forEach((tab, place) => tab.setAttribute("aria-pressed", String(place === index)));
      this.both.hidden = Boolean(index);
      this.scene.element.hidden = !index;
      if (index) this.showScene();
    }

    async showScene() {
      if (this.opened3d && this.data.done) this.scene.show(await this.allSteps());
    }

    goal() {
      const {episode} = this.data.about;
      if (!episode) return null;
      const texts = Object.entries(episode.instruction || {});
      const goal = ["Find ", h("b", {}, h("bdi", {}, episode.target)),
        ` in ${episode.scene}; within ${number(episode.radius)} m counts as reached. Shortest route: ${metres(episode.shortest_m)}.`];
      return h("div", {class: "goal"}, h("p", {}, episode.walk ? `Questions after a walk in ${episode.scene}.` : goal),
      texts.map(([language, text]) => h("p", {class: "told-way"}, `Told in ${language}: `, h("q", {}, h("bdi", {}, text)))));
    }

    summary() {
      const record = this.record;
      return record ? `${record.outcome}: ${foundry.camera.command(record.command)}.` : "";
    }

    async grown(wanted) {
      foundry.showState(this.state, this.data);
      await foundry.camera.begin(this.data);
      this.clock.setSteps(this.data.done);
      this.player.showGrowing(!this.data.ended && foundry.source.live);
      if (wanted) this.player.begin(wanted.step, this.data.written);
      this.showScene();
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
      this.plan.draw(step, clock.share);
      if (!clock.playing) {
        foundry.remember({step});
        this.plan.label();
      }
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
    needs: ["camera/sights.js", "camera/picture.js", "camera/row.js", "camera/ways.js"],
    overlay: (runs, options) => new foundry.Ways(runs, options),
    page: (data, wanted) => new CameraPage(data, wanted),
    panel: (data) => new foundry.camera.SeenImage(data),
    arranged: (panels, looks) => new foundry.camera.Row(panels, looks).element,
    chunk: (block) => block,
    same(chunk, about, step) {
      const record = chunk.steps[step - chunk.first];
      return JSON.stringify([record.pose, record.command, record.outcome]);
    },
    decision: decisionView,
    outcome: ({record}) => record?.outcome,
    decided: ({command}) => `chose ${foundry.camera.command(command)}`,
    player: () => ({kinds: ["failure", "boundary"], signs: ["success"], fires: []}),
  });
})(window.Foundry);
