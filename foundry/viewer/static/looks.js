"use strict";
/* How models look, by the same numbers as in plots and the report: see foundry/palette. */
(function (foundry) {
  const {s} = foundry.dom, {colours, markers, dashes, baseline} = foundry.palette;

  /** Return the look of the model at a place among those of its sweep. */
  function look(place) {
    const marker = markers[(place + Math.floor(place / colours.length)) % markers.length];
    return {colour: colours[place % colours.length], marker, dashes: dashes[place % dashes.length]};
  }

  /** Return the look of each model by its name. */
  function ofModels(names) { return new Map(names.map((name, place) => [name, look(place)])); }

  /** Return the look of each run: that of its model; marker and dashes of its own where a model has several runs, and colour where all are of one. */
  function ofRuns(runs) {
    const names = runs.map((run) => run.about.model), [{about}] = runs, {size} = new Set(names);
    return names.map((name, index) => {
      const own = look(index), shared = look(about.models.indexOf(name));
      if (size === 1) return own;
      return size === names.length ? shared : {...own, colour: shared.colour};
    });
  }

  /** Return the corners of a marker as the path of a drawing. */
  function path(marker, radius) { return `M${marker.map(([x, y]) => `${x * radius} ${-y * radius}`).join("L")}Z`; }

  /** Return the marker of a look as a small drawing that stands before the name of its model. */
  function mark({marker, colour}) {
    return s("svg", {class: "marker", viewBox: "-1.2 -1.2 2.4 2.4", width: 12, height: 12, "aria-hidden": "true"}, s("path", {d: path(marker, 1), fill: colour}));
  }

  /** Begin the outline of a marker on a canvas. */
  function trace(pen, marker, x, y, radius) {
    pen.beginPath();
    marker.forEach(([across, up]) => pen.lineTo(x + radius * across, y - radius * up));
    pen.closePath();
  }

  /** Return the lengths of strokes and gaps of a line of this width. */
  function broken({dashes: lengths}, width) { return lengths.map((one) => one * width); }

  foundry.looks = {look, ofModels, ofRuns, path, mark, trace, broken, baseline};
})(window.Foundry);
