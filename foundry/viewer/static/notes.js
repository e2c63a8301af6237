"use strict";
/* Notes of people on runs and moments. Every page shows them; only a served page can change them. */
(function (foundry) {
  const {h, fill, announce} = foundry.dom;
  function placeOf({step, agent}) { return step === null ? "the run" : `step ${step}${agent === null ? "" : ` · agent ${agent}`}`; }

  /** Return the address of the subject of a note or a search result: a run, a moment of a run, or a moment of a probe. */
  function addressOf(sweep, {run, step, agent, moment = null}) {
    if (moment !== null) return `#/sweep/${sweep}?moment=${moment}`;
    const at = Object.entries({step, agent}).filter(([, number]) => number !== null);
    return `#/run/${sweep}/${run}${at.length ? `?${new URLSearchParams(at)}` : ""}`;
  }

  class Notes {
    /**
     * @param sweep the sweep's id
     * @param runs the runs whose notes are shown, each with `id` and `name`
     * @param options.where returns the moment on the page: `step` and `agent`, or null for each; in a probe also `moment` and `run`
     * @param options.name returns the subject of a note in words
     * @param options.onPick called with the note whose subject the user wants to see; without it, a note is a link to its run
     * @param options.onChange called after notes have changed
     * @param options.folded whether the box is hidden while there is no note and nobody writes one
     */
    constructor(sweep, runs, options) {
      this.sweep = sweep;
      this.runs = runs;
      this.options = options;
      this.list = h("ul", {class: "notes-list"});
      this.state = h("p", {class: "note", role: "status"});
      this.element = h("section", {class: "notes", "aria-label": "Notes", hidden: Boolean(options.folded)}, h("h2", {}, "Notes"), this.list, this.state, foundry.source.live ? this.form() : null);
    }

    form() {
      this.run = h("select", {"aria-label": "Run of the note", hidden: this.runs.length < 2}, this.runs.map(({id, name}) => h("option", {value: id}, name)));
      this.place = h("select", {"aria-label": "Subject of the note"});
      this.text = h("textarea", {rows: "2", placeholder: "Your note", "aria-label": "Note", maxlength: "10000"});
      this.tags = h("input", {placeholder: "tags, with spaces between them", "aria-label": "Tags"});
      this.who = h("input", {placeholder: "your name", "aria-label": "Your name", maxlength: "80"});
      const form = h("form", {onsubmit: (event) => { event.preventDefault(); this.save(); }, onkeydown: (event) => this.key(event)},
        this.run, this.place, this.text, this.tags, this.who, h("p", {class: "row"}, h("button", {}, "Save"), " ", h("button", {type: "button", onclick: () => this.leave()}, "Cancel")));
      this.writing = h("details", {ontoggle: () => this.toggled()}, h("summary", {}, "write a note"), form);
      return this.writing;
    }

    key(event) {
      if (event.key === "Escape") this.leave();
      else if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) this.save();
    }

    async load() {
      try {
        this.draw(await foundry.source.json(`sweep/${this.sweep}/notes`));
      } catch (error) {
        this.state.textContent = error.message;
      }
    }

    draw({notes, unread}) {
      const last = notes.reduce((latest, note) => (note.when > (latest?.when || "") && note.who ? note : latest), null);
      if (this.who && !this.who.value && last) this.who.value = last.who; // the last writer in this sweep
      const names = new Map(this.runs.map(({id, name}) => [id, name]));
      const shown = notes.filter((note) => names.has(note.run)).sort((a, b) => (a.step ?? 0) - (b.step ?? 0));
      fill(this.list, shown.map((note) => h("li", {"data-note": note.note}, this.runs.length > 1 ? `${names.get(note.run)}: ` : null, this.way(note), " ", h("bdi", {}, note.text), " ",
        note.tags.map((tag) => [h("span", {class: "tag"}, tag), " "]), h("small", {}, `${note.who ? `${note.who}, ` : ""}${note.when.slice(0, 16).replace("T", " ")} UTC `), foundry.source.live ? this.changes(note) : null)));
      this.state.textContent = [shown.length ? "" : "No notes yet.", ...unread].filter(Boolean).join(" ");
      this.isEmpty = !shown.length && !unread.length;
      this.fold();
    }

    fold() { this.element.hidden = Boolean(this.options.folded) && this.isEmpty && !this.writing?.open; }

    name(note) { return (this.options.name || placeOf)(note); }

    /** Return a link to the moment of a note. */
    way(note) {
      const {onPick} = this.options, place = this.name(note);
      if (note.step === null) return h("b", {}, place);
      if (onPick) return h("button", {type: "button", class: "go", onclick: () => onPick(note)}, place);
      return h("a", {href: addressOf(this.sweep, note)}, place);
    }

    changes(note) {
      return [h("button", {type: "button", class: "go", "aria-label": `Change the note: ${note.text}`, onclick: () => this.change(note)}, "change"),
        h("button", {type: "button", class: "go", "aria-label": `Delete the note: ${note.text}`, onclick: () => this.send({...note, text: "", tags: [], deleted: true}, "The note is deleted.")}, "✕")];
    }

    /** Start a note on the present view. */
    write() {
      if (!foundry.source.live) return;
      this.changed = null;
      this.text.value = this.tags.value = "";
      this.show();
    }

    change(note) {
      this.changed = note;
      this.text.value = note.text;
      this.tags.value = note.tags.join(" ");
      this.show();
    }

    show() {
      this.element.hidden = false;
      this.writing.open = true;
      this.writing.getBoundingClientRect(); // Chromium 156 never paints a form that is changed and focused before it is laid out
      this.offer();
      this.text.focus();
      this.writing.scrollIntoView({block: "nearest"});
    }

    toggled() { if (this.writing.open && !this.place.options.length) this.write(); }

    /** Offer the possible subjects of a new note. A note that is being changed keeps its subject. */
    offer() {
      const at = this.options.where(), {step, agent} = at, run = {step: null, agent: null};
      const given = this.changed || ("moment" in at ? at : null);
      this.places = given ? [given] : [...agent === null || step === null ? [] : [{step, agent}], ...step === null ? [] : [{step, agent: null}], run];
      fill(this.place, this.places.map((place, index) => h("option", {value: String(index)}, `on ${this.name(place)}`)));
      this.run.disabled = Boolean(given);
      if (given) this.run.value = given.run;
    }

    leave() {
      fill(this.place);
      this.writing.open = false;
      this.fold();
      (this.element.hidden ? document.getElementById("main") : this.writing.querySelector("summary")).focus();
    }

    async save() {
      const {step, agent, moment = null} = this.places[Number(this.place.value)], who = this.who.value.trim();
      const written = {run: this.run.value, step, agent, moment, who, text: this.text.value.trim(), tags: this.tags.value.split(/[\s,]+/).filter(Boolean)};
      if (await this.send(this.changed ? {...written, note: this.changed.note} : written, "The note is saved.")) this.leave();
    }

    /** Send a note; return whether the server accepted it. */
    async send({when, ...note}, said) {
      try {
        this.draw(await foundry.source.send(`sweep/${this.sweep}/notes`, note));
      } catch (error) {
        this.state.textContent = error.message;
        return false;
      }
      announce(said);
      if (this.options.onChange) this.options.onChange();
      return true;
    }
  }

  /** Return the notes of a run, for its page. The moment is the step of the clock and the chosen agent, if any. */
  function notesOfRun(page) {
    const {data} = page, notes = new Notes(data.sweep, [{id: data.id, name: data.name}], {
      folded: true,
      where: () => ({step: page.clock.step || null, agent: page.agent ?? null}),
      onPick: ({step, agent}) => {
        if (page.select) page.select(agent);
        page.clock.pause();
        page.clock.seek(step);
      }});
    notes.load();
    return notes;
  }

  Object.assign(Notes, {placeOf, addressOf});
  foundry.notesOfRun = notesOfRun;
  foundry.Notes = Notes;
})(window.Foundry);
