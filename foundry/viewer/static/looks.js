"use strict";
/* Colours and marks of models, which are the same as in plots and in the report: see foundry/palette. */
(function (foundry) {
  const {s} = foundry.dom, {colours, markers, dashes, baseline} = foundry.palette;

  /** Return the colour and mark of the model at a position in the list of its sweep's models. */
  function look(place) {
    const marker = markers[(place + Math.floor(place / colours.length)) % markers.length];
    return {colour: colours[place % colours.length], marker, dashes: dashes[place % dashes.length]};
  }

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
      const own = look(index), shared = look(models.indexOf(name));
      if (size === 1) return own;
      return size === names.length ? shared : {...own, colour: shared.colour};
    });
  }

  function ofRuns(runs) { return ofItems(runs.map((run) => run.about.model), runs[0].about.models); }

  /** Return the corners of a marker as the path of an SVG. */
  function path(marker, radius) { return `M${marker.map(([x, y]) => `${x * radius} ${-y * radius}`).join("L")}Z`; }

  /** Return the marker of a model as a small drawing before the name of the model. */
  function mark({marker, colour}) {
    return s("svg", {class: "marker", viewBox: "-1.2 -1.2 2.4 2.4", width: 12, height: 12, "aria-hidden": "true"}, s("path", {d: path(marker, 1), fill: colour}));
  }

  /** Begin the outline of a marker on a canvas. */
  function trace(pen, marker, x, y, radius) {
    pen.beginPath();
    marker.forEach(([across, up]) => pen.lineTo(x + radius * across, y - radius * up));
    pen.closePath();
  }

  /** Return the lengths of the dashes and gaps of a line of this width. */
  function broken({dashes: lengths}, width) { return lengths.map((one) => one * width); }

  foundry.looks = {look, ofModels, ofItems, ofRuns, path, mark, trace, broken, baseline};
})(window.Foundry);
