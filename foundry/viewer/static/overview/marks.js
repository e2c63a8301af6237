"use strict";
/* One shape a world, and small pictures of values on one scale. */
(function (foundry) {
  const {s} = foundry.dom;
  const SHAPES = [
    "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z", "M-4-4h8v8h-8z", "M0-5l5 9h-10z", "M0-5l5 5l-5 5l-5-5z", "M0 5l5-9h-10z",
    "M-5-2h3v-3h4v3h3v4h-3v3h-4v-3h-3z",
  ];
  const WIDTH = 130, HEIGHT = 26, EDGE = 6;

  /** Return the shape of each world in turn: those in excess begin anew. */
  function shapes(worlds) { return new Map(worlds.map((name, index) => [name, SHAPES[index % SHAPES.length]])); }

  /** Return what turns a value into a place from 0 to width, and its ends; all values alike stand in the middle. */
  function scale(values, width) {
    const low = values.reduce((a, b) => Math.min(a, b), Infinity), high = values.reduce((a, b) => Math.max(a, b), -Infinity);
    const place = (value) => (high > low ? EDGE + ((value - low) / (high - low)) * (width - 2 * EDGE) : width / 2);
    return {low, high, place};
  }

  /** Draw seeds as strokes, the interval as a bar and the mean as a dot; the numbers stand beside it. */
  function strip(seeds, [mean, low, high], {place}, colour) {
    const at = [...new Set(seeds.map((value) => Math.round(2 * place(value)) / 2))];
    return s("svg", {class: "strip", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, width: WIDTH, height: HEIGHT, "aria-hidden": "true"},
      s("line", {class: "axis", x1: 0, x2: WIDTH, y1: 20, y2: 20}),
      at.map((x) => s("line", {class: "seed", x1: x, x2: x, y1: 15, y2: 25})),
      low === null ? null : s("line", {x1: place(low), x2: place(high), y1: 8, y2: 8, stroke: colour, "stroke-width": 3}),
      mean === null ? null : s("circle", {cx: place(mean), cy: 8, r: 4.5, fill: colour}));
  }

  /** Draw the sign of a model or a world, for a legend. */
  function sign(shape, colour) {
    return s("svg", {viewBox: "-7 -7 14 14", width: 14, height: 14, "aria-hidden": "true"}, s("path", {d: shape, fill: colour}));
  }

  foundry.marks = {WIDTH, scale, strip, sign, shapes};
})(window.Foundry);
