"use strict";
/* Notes on the page of a sweep: a column with their tags and numbers, and a window with the notes of a run. */
(function (foundry) {
  const {h, fill, grouped} = foundry.dom, {placeOf} = foundry.Notes;

  class Noted {
    /** @param onTag called with the tag that the user clicked; @param onChange called after notes have changed */
    constructor(sweep, {onTag, onChange}) {
      Object.assign(this, {sweep, onTag, onChange, ofRun: new Map()});
      this.element = h("div");
      this.unread = h("div");
      this.saving = h("input", {type: "checkbox"});
      this.choice = h("label", {title: "The CSV file then has columns with the tags and notes, but not their authors", hidden: true}, this.saving, " with notes");
    }

    async load() {
      const {notes, unread} = await foundry.source.json(`sweep/${this.sweep}/notes`);
      fill(this.unread, unread.map((why) => h("p", {class: "warning"}, why)));
      this.ofRun = grouped(notes, (note) => note.run);
      this.choice.hidden = !notes.length;
    }

    /** Add the notes of a run to its row. */
    tell(row) {
      const notes = this.ofRun.get(row.run) || [], tags = notes.flatMap((note) => note.tags);
      row.notes = notes.length;
      row.tags = new Set(tags.map((tag) => tag.toLocaleLowerCase()));
      return notes.flatMap((note) => [note.text, note.who, ...note.tags]);
    }

    /** Return the column of notes; none if there are no notes and nobody can write any. */
    columns() {
      if (!foundry.source.live && !this.ofRun.size) return [];
      return [{key: "notes", label: "notes", value: (row) => row.notes, cell: (row) => this.cell(row)}];
    }

    /** Return the columns of notes for a saved file; none unless the user wants them. */
    saved() {
      const notes = ({run}) => this.ofRun.get(run) || [];
      return this.choice.hidden || !this.saving.checked ? [] : [
        {key: "tags", value: (row) => [...new Set(notes(row).flatMap((note) => note.tags))].join(" ")},
        {key: "notes", value: (row) => notes(row).filter((note) => note.text).map((note) => `${placeOf(note)}: ${note.text}`).join("\n")}];
    }

    cell({run, notes, tags}) {
      const tag = (name) => [h("button", {type: "button", class: "tag", "aria-label": `Only runs with the tag ${name}`, onclick: () => this.onTag(name)}, name), " "];
      return [[...tags].map(tag), !notes && !foundry.source.live ? null : h("button", {type: "button", class: "go", "aria-label": `Notes on ${run}`, onclick: () => this.open(run)}, notes ? `✎ ${notes}` : "✎")];
    }

    /** Show the notes of a run in a separate window. */
    open(run) {
      const notes = new foundry.Notes(this.sweep, [{id: run, name: run}], {where: () => ({step: null, agent: null}), onChange: () => this.onChange()});
      const dialog = h("dialog", {class: "noted", "aria-label": `Notes on ${run}`, onclose: () => this.closed(dialog, run)},
        h("p", {}, h("b", {}, run)), notes.element, h("button", {type: "button", onclick: () => dialog.close()}, "Close"));
      this.element.append(dialog);
      dialog.showModal();
      notes.load();
      notes.write();
    }

    closed(dialog, run) {
      dialog.remove();
      [...document.querySelectorAll("[aria-label]")].find((node) => node.ariaLabel === `Notes on ${run}`)?.focus();
    }
  }

  foundry.Noted = Noted;
})(window.Foundry);
