"use strict";
/* Shows the picture of a step: a saved picture, or one that the world draws again from the records. */
(function (foundry) {
  const {h} = foundry.dom;
  const KEPT = 12;

  class Picture {
    constructor(data) {
      this.data = data;
      this.urls = new Map();
      this.image = h("img", {alt: "", hidden: true});
      this.note = h("p", {class: "note", hidden: true});
      this.caption = h("span");
      this.before = h("input", {type: "checkbox", onchange: () => this.show(this.step)});
      this.controls = h("figcaption", {hidden: true}, this.caption, h("label", {}, this.before, " show the state before the step"));
      this.element = h("figure", {class: "picture"}, this.image, this.controls, this.note);
    }

    /** Load the list of pictures. While the run grows, load it again, because a picture may be saved later. */
    async look() {
      if (this.there && this.there.why === "") return;
      this.there = await foundry.source.json(`${this.data.address}/pictures`);
      this.element.hidden = this.there.lanes;
      this.show(this.step);
    }

    has(step) { return this.there.why === "" || this.there.kept.includes(step); }

    /** Show the picture of a step. While a picture loads, remember only the latest request. */
    async show(step) {
      this.step = step;
      if (!step || !this.there || this.there.lanes || this.busy) return;
      const wanted = this.before.checked ? step - 1 : step;
      if (!this.has(wanted)) { this.say(`There is no picture after step ${wanted}: ${this.there.why}`); return; }
      this.busy = true;
      try {
        const url = await this.url(wanted);
        if (!this.disposed) this.fill(wanted, url);
      } catch (error) {
        this.say(`The picture cannot be shown: ${error.message}`);
      }
      this.busy = false;
      if (!this.disposed && (this.step !== step || (this.before.checked ? step - 1 : step) !== wanted)) this.show(this.step);
    }

    async url(step) {
      const key = `${this.data.progress.beginning}/${step}`;
      if (!this.urls.has(key)) {
        const bytes = await foundry.source.bytes(`${this.data.address}/picture/${step}`);
        this.urls.set(key, URL.createObjectURL(new Blob([bytes], {type: "image/png"})));
        const [oldest] = this.urls.keys();
        if (this.urls.size > KEPT) { URL.revokeObjectURL(this.urls.get(oldest)); this.urls.delete(oldest); }
      }
      return this.urls.get(key);
    }

    fill(step, url) {
      this.image.src = url;
      this.image.alt = step ? `The world after step ${step}` : "The world at the beginning";
      this.caption.textContent = step ? `After step ${step}` : "At the beginning";
      this.image.hidden = this.controls.hidden = false;
      this.note.hidden = true;
    }

    say(text) {
      this.note.textContent = text;
      this.image.hidden = true;
      this.note.hidden = false;
      this.controls.hidden = !this.there.kept.length;
    }

    dispose() {
      this.disposed = true;
      for (const url of this.urls.values()) URL.revokeObjectURL(url);
    }
  }

  foundry.Picture = Picture;
})(window.Foundry);
