"use strict";
/* Takes a moment of runs away: a picture, the decisions as JSON, a link; model, seed and step are written in. */
(function (foundry) {
  const {h, color, announce} = foundry.dom;
  const WIDTH = 560, HEAD = 46, FOOT = 26, GAP = 12, ACROSS = 3, LINES = 3, LINE = 18;

  /** Return what the drawings of a panel look like together: its canvases and images that are shown, one below the other. */
  function drawings(element) {
    return [...element.querySelectorAll("canvas, img")].filter((one) => one.clientWidth > 40 && (one.tagName !== "IMG" || one.naturalWidth));
  }

  /** Return whether a drawing lies over the one before it, as marks on a picture do; its `paint` draws it in any size. */
  function isLaidOver(one) { return one.classList.contains("laid-over"); }

  function tallOf(one) { return WIDTH * one.clientHeight / one.clientWidth; }

  /** Return text as it fits into a width. */
  function fitted(pen, text, width) {
    if (pen.measureText(text).width <= width) return text;
    let fits = 0, over = text.length;
    while (over - fits > 1) {
      const middle = Math.floor((fits + over) / 2);
      if (pen.measureText(`${text.slice(0, middle)}…`).width <= width) fits = middle; else over = middle;
    }
    return `${text.slice(0, fits)}…`;
  }

  /** Return the lines that were said in a run at a step. */
  async function spoken(run, step) {
    if (step < 1 || step > run.done) return [];
    const {texts} = await run.texts(Math.floor((step - 1) / run.about.steps_per_chunk));
    return texts.filter(([at]) => at === step).map(([, agent, text]) => (run.about.agents > 1 ? `agent ${agent}: ${text}` : text));
  }

  class Moment {
    /**
     * @param clock says which step is shown
     * @param what returns {panels: [{run, element}], agent, decisions()} of this moment
     */
    constructor(clock, what) {
      Object.assign(this, {clock, what});
      this.state = h("span", {class: "note", role: "status"});
      this.element = h("div", {class: "choices moment"}, "This moment: ",
        h("button", {type: "button", onclick: () => this.savePicture()}, "picture (PNG)"), h("button", {type: "button", onclick: () => this.saveJson()}, "decisions (JSON)"),
        h("button", {type: "button", onclick: () => this.copyLink()}, "copy link"), this.state);
    }

    get link() {
      const {agent} = this.what();
      return `${location.href.split("#")[0]}${location.hash.split("?")[0]}?step=${this.clock.step}${agent === null ? "" : `&agent=${agent}`}`;
    }

    name(ending) {
      const {panels} = this.what();
      return `${[...new Set(panels.map(({run}) => run.about.model))].join("-").replace(/[^\w.-]+/g, "_").slice(0, 80)}-seed${panels[0].run.about.seed}-step${this.clock.step}.${ending}`;
    }

    async saveJson() {
      const {panels, agent, decisions} = this.what(), {step} = this.clock, found = await decisions();
      const runs = panels.map(({run}, index) => ({sweep: run.sweep, run: run.id, model: run.about.model, prompt: run.about.prompt, world: run.about.world, seed: run.about.seed, decision: found && found[index]}));
      foundry.download.blob(new Blob([JSON.stringify({link: this.link, step, agent, runs}, null, 1)], {type: "application/json"}), this.name("json"));
    }

    /**
     * Return one picture of all panels, each with its model, prompt, seed and step above and what was said below, and the link.
     * @param said the lines that were said in each run
     */
    picture(said) {
      const {panels} = this.what(), {step} = this.clock, seen = panels.map(({element}) => drawings(element));
      const heights = seen.map((all) => all.filter((one) => !isLaidOver(one)).reduce((sum, one) => sum + tallOf(one), 0)), most = Math.max(...heights);
      const across = Math.min(ACROSS, panels.length), tall = most + HEAD + (said.some((lines) => lines.length) ? LINES * LINE + GAP : 0), rows = Math.ceil(panels.length / across);
      const sheet = h("canvas", {width: String(across * (WIDTH + GAP) + GAP), height: String(Math.round(rows * (tall + GAP) + FOOT + GAP))}), pen = sheet.getContext("2d");
      pen.fillStyle = color("paper");
      pen.fillRect(0, 0, sheet.width, sheet.height);
      panels.forEach(({run}, index) => {
        const left = GAP + (index % across) * (WIDTH + GAP), from = GAP + Math.floor(index / across) * (tall + GAP);
        let top = from + HEAD;
        this.write(pen, run.about.model, left, from + 18, "600 18px system-ui, sans-serif");
        this.write(pen, `${run.about.prompt} · ${run.about.world} · seed ${run.about.seed} · step ${step}${step > run.done ? `, after its last, ${run.done}` : ""}`, left, from + 38, "14px system-ui, sans-serif");
        for (const one of seen[index]) {
          const height = tallOf(one);
          if (isLaidOver(one)) { one.paint(pen, {left, top: top - height, width: WIDTH, height}); continue; }
          pen.drawImage(one, left, top, WIDTH, height);
          top += height;
        }
        this.writeSaid(pen, said[index], left, from + HEAD + most + LINE);
      });
      this.write(pen, this.link, GAP, sheet.height - GAP, "12px system-ui, sans-serif", sheet.width - 2 * GAP);
      return sheet;
    }

    writeSaid(pen, lines, left, top) {
      const shown = lines.length > LINES ? [...lines.slice(0, LINES - 1), `and ${lines.length - LINES + 1} more`] : lines;
      shown.forEach((line, index) => this.write(pen, line.replace(/\s+/g, " "), left, top + index * LINE, "13px system-ui, sans-serif"));
    }

    write(pen, text, x, y, font, width = WIDTH) {
      pen.font = font;
      pen.fillStyle = color("ink");
      pen.fillText(fitted(pen, foundry.dom.visible(text), width), x, y);
    }

    async savePicture() {
      try {
        const said = await Promise.all(this.what().panels.map(({run}) => spoken(run, this.clock.step)));
        this.picture(said).toBlob((blob) => foundry.download.blob(blob, this.name("png")), "image/png");
      } catch (error) {
        this.state.textContent = `No picture can be taken here: ${error.message}`;
      }
    }

    async copyLink() {
      try {
        await navigator.clipboard.writeText(this.link);
        announce("The link is copied.");
      } catch {
        announce(`It cannot be copied here; the link is ${this.link}`);
      }
    }
  }

  /** Return the moment of a page of one run, of which `element` is pictured. */
  Moment.ofRun = (page, element) => new Moment(page.clock, () => {
    const {data} = page, asked = data.about.agents > 1 ? page.agent : 0;
    return {panels: [{run: data, element}], agent: page.agent, decisions: async () => (asked === null ? null : [await data.decision(page.clock.step, asked)])};
  });

  foundry.Moment = Moment;
})(window.Foundry);
