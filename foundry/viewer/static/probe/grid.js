"use strict";
/* What an agent of the 2D world perceives, drawn from its observation: itself, who is near, places, fires. */
(function (foundry) {
  const {h, s, number} = foundry.dom;

  foundry.perceived.grid = (seen, told) => {
    const size = seen.half_size + 1, text = (x, y, words, kind) => s("text", {x, y: -y, class: kind, "text-anchor": "middle"}, words);
    const places = (seen.places || []).flatMap((one) => [
      s("rect", {class: "place", x: one.x_min - 0.5, y: -one.y_max - 0.5, width: one.x_max - one.x_min + 1, height: one.y_max - one.y_min + 1}),
      text(one.x, one.y_max + 1, one.name, "place-name")]);
    const fires = (seen.fires || []).flatMap((one) => [
      s("circle", {class: "fire-reach", cx: one.x, cy: -one.y, r: one.radius}), text(one.x, one.y - 0.8, "✹", "fire"), text(one.x, one.y + 1.6, one.name, "fire-name")]);
    const others = (seen.neighbours || []).flatMap((one) => [
      s("line", {class: "near", x1: seen.x, y1: -seen.y, x2: one.x, y2: -one.y}), s("circle", {class: "other", cx: one.x, cy: -one.y, r: 1}), text(one.x, one.y - 0.45, one.id, "id")]);
    const self = [s("circle", {class: "self", cx: seen.x, cy: -seen.y, r: 1.2}), text(seen.x, seen.y - 0.45, seen.agent, "id")];
    const also = [`at ${number(seen.x)}, ${number(seen.y)}`, `${(seen.neighbours || []).length} near`, `${(seen.fires || []).length} fires`, `${(seen.received || []).length} messages`];
    return h("div", {class: "map"}, s("svg", {viewBox: `${-size} ${-size} ${2 * size} ${2 * size}`, role: "img", "aria-label": `${told}: ${also.join(", ")}`},
      s("rect", {class: "field", x: -size + 0.5, y: -size + 0.5, width: 2 * size - 1, height: 2 * size - 1}), ...places, ...fires, ...others, ...self));
  };
})(window.Foundry);
