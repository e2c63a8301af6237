"use strict";
/* Colours and marks of models, which are the same as in plots and in the report: see foundry/palette. */
(function (foundry) {
  const {s} = foundry.dom, {colours, dark_colours: darks, markers, dashes, baseline} = foundry.palette;
  const isDark = window.matchMedia("(prefers-color-scheme: dark)");

  class Look {
    /** @param place position of a model in the list of its sweep's models; `hue` is the position of the model with its colour */
    constructor(place, hue = place) {
      this.marker = markers[(place + Math.floor(place / colours.length)) % markers.length];
      this.dashes = dashes[place % dashes.length];
      this.hue = hue % colours.length;
    }

    /** The colour on the present background, for a canvas. */
    get colour() { return (isDark.matches ? darks : colours)[this.hue]; }

    /** The colour as CSS, for elements that stay when the background changes. */
    get paint() { return `light-dark(${colours[this.hue]}, ${darks[this.hue]})`; }
  }

  /** Return the colour and mark of the model at a position in the list of its sweep's models. */
  function look(place) { return new Look(place); }

  /** Return the colour and mark of each model by its name. */
  function ofModels(names) { return new Map(names.map((name, place) => [name, look(place)])); }

  /**
   * Return the colour and mark of each item of a list, such as a run: those of its model. Items of the same model differ
   * by mark and dashes, and also by colour if there is only one model.
   * @param names the model of each item
   * @param models all models of the sweep
   */
  function ofItems(names, models) {
    const {size} = new Set(names);
    return names.map((name, index) => {
      const model = models.indexOf(name);
      if (size === 1) return look(index);
      return size === names.length ? look(model) : new Look(index, model);
    });
  }

  function ofRuns(runs) { return ofItems(runs.map((run) => run.about.model), runs[0].about.models); }

  /** Return the corners of a marker as the path of an SVG. */
  function path(marker, radius) { return `M${marker.map(([x, y]) => `${x * radius} ${-y * radius}`).join("L")}Z`; }

  /** Return the marker of a model as a small drawing before the name of the model. */
  function mark({marker, paint}) {
    return s("svg", {class: "marker", viewBox: "-1.2 -1.2 2.4 2.4", width: 12, height: 12, "aria-hidden": "true"}, s("path", {d: path(marker, 1), fill: paint}));
  }

  /** Return a line of a model as a small drawing in a legend; `radius` is the size of its marker, and 0 draws none. */
  function line(look, {width, height, radius = 0}) {
    const middle = height / 2;
    return s("svg", {class: "sample", viewBox: `0 0 ${width} ${height}`, width, height, "aria-hidden": "true"},
      s("path", {d: `M0 ${middle}H${width}`, stroke: look.paint, "stroke-width": 2, "stroke-dasharray": broken(look, 2).join(" ")}),
      radius ? s("path", {d: path(look.marker, radius), transform: `translate(${width / 2} ${middle})`, fill: look.paint}) : null);
  }

  /** Begin the outline of a marker on a canvas. */
  function trace(pen, marker, x, y, radius) {
    pen.beginPath();
    marker.forEach(([across, up]) => pen.lineTo(x + radius * across, y - radius * up));
    pen.closePath();
  }

  /** Return the lengths of the dashes and gaps of a line of this width. */
  function broken({dashes: lengths}, width) { return lengths.map((length) => length * width); }

  foundry.looks = {look, ofModels, ofItems, ofRuns, mark, line, trace, broken, baseline};
})(window.Foundry);
