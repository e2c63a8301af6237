"use strict";
/* Draws an agent's observation in a 2D world: the agent, its neighbours, places, fires, walls, exits, food, zones. */
(function (foundry) {
  const {h, s, number} = foundry.dom;

  const KINDS = {"#": "wall", "?": "hidden", "E": "exit"};

  /* The marked cells of the visible window, up to the edge. Without a limit of view, the window is the whole grid. */
  function windowed(seen) {
    const [x, y, reach] = seen.view == null ? [0, 0, seen.half_size] : [seen.x, seen.y, seen.view];
    return (seen.window || []).flatMap((row, down) => [...row].flatMap((mark, right) => {
      const at = {x: x - reach + right, y: y + reach - down};
      return KINDS[mark] && Math.max(Math.abs(at.x), Math.abs(at.y)) <= seen.half_size ? [cell(at, KINDS[mark])] : [];
    }));
  }

  function cell(at, kind) { return s("rect", {class: kind, x: at.x - 0.5, y: -at.y - 0.5, width: 1, height: 1}); }

  foundry.perceived.grid = (seen, told) => {
    const size = seen.half_size + 1.5, text = (x, y, words, kind) => s("text", {x, y: -y, class: kind, "text-anchor": "middle"}, words);
    const places = (seen.places || []).flatMap((one) => [
      s("rect", {class: "place", x: one.x_min - 0.5, y: -one.y_max - 0.5, width: one.x_max - one.x_min + 1, height: one.y_max - one.y_min + 1}),
      text(one.x, one.y_max + 1, one.name, "place-name")]);
    const fires = (seen.fires || []).flatMap((one) => [
      s("circle", {class: "fire-reach", cx: one.x, cy: -one.y, r: one.radius}), text(one.x, one.y - 0.8, "✹", "fire"), text(one.x, one.y + 1.6, one.name, "fire-name")]);
    const others = (seen.neighbours || []).flatMap((one) => [
      s("line", {class: "near", x1: seen.x, y1: -seen.y, x2: one.x, y2: -one.y}), s("circle", {class: "other", cx: one.x, cy: -one.y, r: 1}), text(one.x, one.y - 0.45, one.id, "id")]);
    const near = new Set((seen.neighbours || []).map((one) => one.id));
    const far = (seen.seen || []).filter((one) => !near.has(one.id)).flatMap((one) => [
      s("circle", {class: "other", cx: one.x, cy: -one.y, r: 1}), text(one.x, one.y - 0.45, one.id, "id")]);
    const zones = (seen.zones || []).flatMap((one) => [
      s("rect", {class: "zone", x: one.x_min - 0.5, y: -one.y_max - 0.5, width: one.x_max - one.x_min + 1, height: one.y_max - one.y_min + 1}),
      text((one.x_min + one.x_max) / 2, one.y_max + 1, one.name, "zone-name")]);
    const food = seen.food || [], here = food.some((one) => one.x === seen.x && one.y === seen.y);
    const ground = [...windowed(seen), ...(seen.exits || []).map((one) => cell(one, "exit")), ...food.map((one) => cell(one, "food")),
      ...(seen.burning || []).map(([x, y]) => cell({x, y}, "burning"))];
    const self = [s("circle", {class: "self", cx: seen.x, cy: -seen.y, r: 1.2}), text(seen.x, seen.y - 0.45, seen.agent, "id")];
    const also = [`at ${number(seen.x)}, ${number(seen.y)}`, `${(seen.neighbours || []).length} near`, ...(seen.seen ? [`${far.length / 2} more seen`] : []), `${(seen.fires || []).length} fires`,
      ...(seen.energy == null ? [] : [`energy ${number(seen.energy)}`, `food in ${food.length} cells${here ? ", also in the agent's cell" : ""}`]), `${(seen.received || []).length} messages`];
    return h("div", {class: "map"}, s("svg", {viewBox: `${-size} ${-size} ${2 * size} ${2 * size}`, role: "img", "aria-label": `${told}: ${also.join(", ")}`},
      s("rect", {class: "field", x: -size + 1, y: -size + 1, width: 2 * size - 2, height: 2 * size - 2}), ...ground, ...zones, ...places, ...fires, ...far, ...others, ...self, ...food.map((one) => cell(one, "food-edge"))));
  };
})(window.Foundry);
