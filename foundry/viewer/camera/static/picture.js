"use strict";
/* Shows the exact image that the model saw with the target marked, and below it the reading of the reply. */
(function (foundry) {
  const {h, fill, penOf} = foundry.dom, {mark, reading, Sights} = foundry.camera;
  const AGAIN_MS = 500;

  class SeenImage {
    constructor(data) {
      this.data = data;
      this.sights = new Sights(data);
      this.image = h("img", {alt: "", class: "seen", onerror: () => this.again(), onload: () => this.redraw()});
      this.marks = h("canvas", {class: "laid-over", "aria-hidden": "true"});
      this.frame = h("div", {class: "seen-frame"}, this.image, this.marks);
      this.none = h("p", {class: "note"}, "The image of this step was not stored.");
      this.walk = h("div", {class: "walk"});
      this.read = h("p", {class: "read"});
      this.why = h("p", {class: "note", hidden: true});
      this.element = h("figure", {class: "seen-box"}, this.frame, this.none, this.walk, h("figcaption", {}, this.read, this.why));
      new ResizeObserver(() => this.redraw()).observe(this.frame);
    }

    get target() { return this.data.about.episode?.target || ""; }

    /** Show the image of a step if its record is loaded; return whether it is. */
    draw(step) {
      const chunk = step ? this.data.chunkAt(step) : null;
      if (chunk) this.show(chunk.steps[step - chunk.first]);
      return chunk !== null;
    }

    select() {}

    label(name) { this.image.alt = this.about ? `${this.about} (${name})` : ""; }

    show(record) {
      if (this.record === record) return;
      const path = record && record.image;
      Object.assign(this, {record, sight: null});
      this.frame.hidden = !path;
      this.none.hidden = Boolean(path);
      this.showWalk(record?.frames || []);
      this.tell();
      if (record) this.findTarget(record);
      if (!path) return;
      const url = this.address(path);
      if (this.url !== url) this.image.setAttribute("src", url);
      this.url = url;
      this.about = `The image the model saw at step ${record.step}`;
      this.image.alt = this.about;
    }

    async findTarget(record) {
      let mark;
      try {
        mark = await this.sights.at(record.step);
      } catch (error) {
        mark = {sight: null, why: error.message};
      }
      if (this.record !== record) return;
      this.sight = mark.sight;
      this.why.hidden = !mark.why;
      this.why.textContent = `The target is not marked: ${mark.why}`;
      this.tell();
    }

    tell() {
      fill(this.read, this.record ? reading(this.record, this.sight, this.target) : null);
      this.redraw();
    }

    /** Show the image with or without the marks. */
    setMarked(marked) {
      this.unmarked = !marked;
      this.redraw();
    }

    redraw() {
      const {clientWidth: width, clientHeight: height} = this.image;
      if (!width || !height) return;
      const pen = penOf(this.marks, width, height);
      if (!this.unmarked && this.image.naturalWidth) mark(pen, {record: this.record, sight: this.sight, name: this.target, width, height});
    }

    address(path) { return foundry.source.file(this.data.sweep, `${this.data.about.folder}/${path}`); }

    /** Show the pictures of the walk that belong to a question, the earliest first. Pictures that are already visible stay. */
    showWalk(paths) {
      if (this.shownWalk === paths.join()) return;
      this.shownWalk = paths.join();
      fill(this.walk, paths.map((path, at) => h("img", {src: this.address(path), alt: `Picture ${at + 1} of the walk`})));
    }

    /** Load the image again a little later: while a run is being written, a record may exist before its image. */
    again() {
      const {url} = this, src = this.image.getAttribute("src");
      if (src === url) setTimeout(() => { if (this.url === url) this.image.setAttribute("src", `${url}?again`); }, AGAIN_MS);
    }
  }

  /** The switch between the image with the target marked and the exact image; null if there is no target to mark. */
  foundry.camera.marking = (images) => (images.some((image) => image.target)
    ? h("label", {class: "marking"}, h("input", {type: "checkbox", checked: true, onchange: (event) => images.forEach((image) => image.setMarked(event.target.checked))}), " target marked")
    : null);

  foundry.camera.SeenImage = SeenImage;
})(window.Foundry);
