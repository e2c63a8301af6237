"use strict";
/* Draws small pictures of values on a common scale. */
(function (foundry) {
  const {s} = foundry.dom;
  const WIDTH = 130, HEIGHT = 26, EDGE = 6;

  /**
   * Return a function from a value to a position from 0 to width, and the ends of its scale. If all values are equal,
   * their position is the middle.
   */
  function scale(values, width) {
    const low = values.reduce((a, b) => Math.min(a, b), Infinity), high = values.reduce((a, b) => Math.max(a, b), -Infinity);
    const place = (value) => (high > low ? EDGE + ((value - low) / (high - low)) * (width - 2 * EDGE) : width / 2);
    return {low, high, place};
  }

  /** Draw seeds as strokes, the interval as a bar and the mean as a dot, next to the numbers. */
  function strip(seeds, [mean, low, high], {place}, colour) {
    const at = [...new Set(seeds.map((value) => Math.round(2 * place(value)) / 2))];
    return s("svg", {class: "strip", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, width: WIDTH, height: HEIGHT, "aria-hidden": "true"},
      s("line", {class: "axis", x1: 0, x2: WIDTH, y1: 20, y2: 20}),
      at.map((x) => s("line", {class: "seed", x1: x, x2: x, y1: 15, y2: 25})),
      low === null ? null : s("line", {x1: place(low), x2: place(high), y1: 8, y2: 8, stroke: colour, "stroke-width": 3}),
      mean === null ? null : s("circle", {cx: place(mean), cy: 8, r: 4.5, fill: colour}));
  }

  foundry.marks = {WIDTH, scale, strip};
})(window.Foundry);
