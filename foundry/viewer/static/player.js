"use strict";
/* Buttons and keys for a clock and its timeline, used for 2D runs, 3D runs and comparisons. */
(function (foundry) {
  const {h, fill, announce} = foundry.dom;

  const KEYS = [
    ["Space", "play or pause"], ["← →", "a step back or forward"], ["Shift ← →", "ten steps"], ["Home End", "start or end"],
    ["+ −", "faster or slower"], ["E", "next event", "events"], ["M", "next message", "message"], ["F", "next fire", "fire"], ["X", "next failed or repaired decision"],
    ["B", "next stopped or shortened move", "boundary"], ["Shift + letter", "back to the previous event, message or move"], ["[ ]", "previous or next agent", "agents"],
    ["Esc", "choose no agent", "agents"], ["/", "search", "search"], ...foundry.source.live ? [["N", "write a note on this moment", "notes"]] : [],
  ];
  const TOLD = 3;
  const SLIDING = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End", "PageUp", "PageDown"];

  class Player {
    /**
     * @param options.marks, options.fires, options.events as for Timeline
     * @param options.why returns the reason why there are no events, or an empty text
     * @param options.kinds the kinds of jumps: "message", "fire", "failure", "boundary"
     * @param options.summary returns the text to announce when the clock stops
     * @param options.agents functions for choosing an agent by key: `most` returns the number of agents; `chosen` returns the chosen agent; `select` takes an agent or null
     * @param options.search the search that a key opens
     * @param options.notes the notes that a key opens
     * @param options.keys further keys of the page, for the list of keys
     */
    constructor(options) {
      this.options = options;
      this.clock = new foundry.Clock();
      this.timeline = new foundry.Timeline(this.clock, options);
      this.label = h("span", {class: "where"});
      this.playButton = this.button("▶", "Play", () => this.clock.toggle(), "play");
      this.speed = h("select", {"aria-label": "Speed, steps per second", onchange: () => this.setSpeed()},
        foundry.SPEEDS.map((speed) => h("option", {value: String(speed)}, `${speed} steps/s`)));
      this.follow = h("input", {type: "checkbox", onchange: () => this.followEnd(this.follow.checked)});
      this.followLabel = h("label", {class: "follow", hidden: true}, this.follow, " follow");
      this.happening = h("p", {class: "happening", hidden: !options.events});
      this.element = h("section", {class: "player", "aria-label": "Timeline"}, this.buttons(), this.timeline.element, h("div", {class: "under"}, this.happening, this.legend()));
      this.clock.onChange(() => this.update());
      this.onKeyDown = (event) => this.key(event);
      document.addEventListener("keydown", this.onKeyDown);
    }

    dispose() {
      this.clock.pause();
      clearTimeout(this.saying);
      document.removeEventListener("keydown", this.onKeyDown);
    }

    button(sign, label, action, id = "") {
      return h("button", {type: "button", title: label, "aria-label": label, onclick: action, "data-do": id || label}, sign);
    }

    buttons() {
      const {clock} = this, jumps = this.options.events && [
        this.button("◂ event", "Event before", () => this.jump("event", -1)), this.button("event ▸", "Next event", () => this.jump("event", 1))];
      return h("div", {class: "buttons"},
        this.button("⇤", "First step", () => clock.seek(1)), this.button("←", "Step back", () => clock.move(-1)),
        this.playButton, this.button("→", "Step on", () => clock.move(1)), this.button("⇥", "Last step", () => clock.seek(clock.end)),
        this.label, this.speed, jumps, this.openers(), this.followLabel,
        foundry.dom.keys([...KEYS.filter(([, , kind]) => !kind || this.options.kinds.includes(kind) || this.options[kind]), ...this.options.keys || []]));
    }

    /** Return buttons that open hidden parts of the page. */
    openers() {
      const {search, notes} = this.options;
      return [search && this.button("search", "Search", () => search.focus()), notes && foundry.source.live && this.button("note", "Write a note", () => notes.write())];
    }

    legend() {
      const signs = {
        message: ["talk", "▮", "messages"], fire: ["fire", "▏", "fire begins"], boundary: ["mended", "▬", "move stopped or shortened"],
        success: ["good", "▬", "goal reached"],
        failure: ["bad", "▼", "no readable reply"],
      };
      const shown = [...this.options.kinds, ...(this.options.signs || [])].map((kind) => signs[kind]).concat([["mended", "◆", "repaired reply"]]);
      this.whose = h("b");
      return h("p", {class: "legend"}, this.whose, shown.map(([tone, sign, text]) =>
        h("span", {}, h("i", {class: `tone-${tone}`, "aria-hidden": "true"}, sign), ` ${text}`)));
    }

    /** Show the agent whose marks the timeline shows. */
    showWhose(text) { this.whose.textContent = text; }

    setSpeed() { this.clock.speed = Number(this.speed.value); }

    update() {
      const {clock} = this;
      this.label.textContent = clock.steps ? `${clock.where} of ${clock.steps}` : "no step yet";
      this.playButton.textContent = clock.playing ? "⏸" : "▶";
      this.playButton.setAttribute("aria-label", clock.playing ? "Pause" : "Play");
      this.playButton.title = clock.playing ? "Pause" : "Play";
      this.speed.value = String(clock.speed);
      if (this.options.events) this.showEvents();
      if (!clock.playing && this.said !== clock.position) {
        this.said = clock.position;
        clearTimeout(this.saying);
        this.saying = setTimeout(() => announce(`${this.label.textContent}. ${this.happening.textContent} ${this.options.summary()}`), 150);
      }
    }

    /** Show the events of the step, or the reason if there are none. */
    showEvents() {
      const here = this.options.events().filter(({step}) => Math.max(1, step) === this.clock.step), why = this.options.why();
      const now = JSON.stringify([here, why, this.options.agents?.chosen()]), more = here.length > TOLD ? ` and ${here.length - TOLD} more` : null;
      if (now === this.happened) return;
      this.happened = now;
      fill(this.happening, why || (here.length ? [here.slice(0, TOLD).map((event, at) => [at ? "; " : null, this.worded(event)]), more] : "No event at this step."));
    }

    /** Return an event in words. A click on them chooses the agent of the event. */
    worded({agent, text}) {
      const {agents} = this.options, words = h("bdi", {}, text);
      return agent === null || !agents || agents.chosen() === agent ? words : h("button", {type: "button", onclick: () => agents.select(agent)}, words);
    }

    /** Draw the marks and the events again. */
    redraw() {
      this.timeline.draw();
      if (this.options.events) this.showEvents();
    }

    /** Begin at the step in the address. A run that is being written is shown and followed at its end. */
    begin(step, written) {
      if (written && step === null) this.followEnd(true);
      else this.clock.seek(step || 1);
    }

    followEnd(following) {
      this.clock.following = this.follow.checked = following;
      this.clock.seek(this.clock.end);
    }

    /** Show that the run still grows, and stay at its end if the user wants this. */
    showGrowing(growing) {
      this.followLabel.hidden = !growing;
      if (!growing) { this.clock.following = false; this.follow.checked = false; }
    }

    jump(kind, direction) {
      const step = kind === "fire" ? this.timeline.nextFire(direction) : kind === "event" ? this.timeline.nextEvent(direction) : this.timeline.next(
        {message: ["said"], failure: ["undecided", "repaired"], boundary: ["boundary"]}[kind], direction);
      this.clock.pause();
      if (step === null) announce(`No ${direction > 0 ? "later" : "earlier"} ${kind}.`);
      else this.clock.seek(step);
    }

    /** Choose the previous or next agent; without a chosen agent, the first. */
    nextAgent(direction) {
      const {most, chosen, select} = this.options.agents, at = chosen();
      if (most()) select(at === null ? 0 : (at + direction + most()) % most());
    }

    key(event) {
      const sliding = event.target.closest("input[type=range]") && SLIDING.includes(event.key);
      if (sliding || foundry.dom.isTyping(event)) return;
      if (event.key === " " && event.target.closest("button, summary, a, input:not([type=range])")) return;
      const {clock} = this, {agents, search, notes} = this.options, back = event.shiftKey ? -1 : 1;
      const jumps = {m: "message", f: "fire", x: "failure", b: "boundary", e: "event"}, known = [...this.options.kinds, this.options.events && "event"];
      const actions = {
        " ": () => clock.toggle(), ArrowRight: () => clock.move(event.shiftKey ? 10 : 1),
        ArrowLeft: () => clock.move(event.shiftKey ? -10 : -1), Home: () => clock.seek(1), End: () => clock.seek(clock.end),
        "+": () => clock.faster(1), "=": () => clock.faster(1), "-": () => clock.faster(-1),
        ...agents && {"[": () => this.nextAgent(-1), "]": () => this.nextAgent(1), Escape: () => agents.select(null)},
        ...search && {"/": () => search.focus()}, ...notes && {n: () => notes.write()},
      };
      const jump = jumps[event.key.toLowerCase()];
      if (actions[event.key]) actions[event.key]();
      else if (jump && known.includes(jump)) this.jump(jump, back);
      else return;
      event.preventDefault();
    }
  }

  foundry.Player = Player;
})(window.Foundry);
