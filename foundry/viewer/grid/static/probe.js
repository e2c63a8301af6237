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

  foundry.perceived.grid = (seen, label) => {
    const size = seen.half_size + 1.5, text = (x, y, words, kind) => s("text", {x, y: -y, class: kind, "text-anchor": "middle"}, words);
    const places = (seen.places || []).flatMap((place) => [
      s("rect", {class: "place", x: place.x_min - 0.5, y: -place.y_max - 0.5, width: place.x_max - place.x_min + 1, height: place.y_max - place.y_min + 1}),
      text(place.x, place.y_max + 1, place.name, "place-name")]);
    const fires = (seen.fires || []).flatMap((fire) => [
      s("circle", {class: "fire-reach", cx: fire.x, cy: -fire.y, r: fire.radius}), text(fire.x, fire.y - 0.8, "✹", "fire"), text(fire.x, fire.y + 1.6, fire.name, "fire-name")]);
    const others = (seen.neighbours || []).flatMap((agent) => [
      s("line", {class: "near", x1: seen.x, y1: -seen.y, x2: agent.x, y2: -agent.y}), s("circle", {class: "other", cx: agent.x, cy: -agent.y, r: 1}), text(agent.x, agent.y - 0.45, agent.id, "id")]);
    const near = new Set((seen.neighbours || []).map((agent) => agent.id));
    const far = (seen.seen || []).filter((agent) => !near.has(agent.id)).flatMap((agent) => [
      s("circle", {class: "other", cx: agent.x, cy: -agent.y, r: 1}), text(agent.x, agent.y - 0.45, agent.id, "id")]);
    const zones = (seen.zones || []).flatMap((zone) => [
      s("rect", {class: "zone", x: zone.x_min - 0.5, y: -zone.y_max - 0.5, width: zone.x_max - zone.x_min + 1, height: zone.y_max - zone.y_min + 1}),
      text((zone.x_min + zone.x_max) / 2, zone.y_max + 1, zone.name, "zone-name")]);
    const food = seen.food || [], here = food.some((at) => at.x === seen.x && at.y === seen.y);
    const ground = [...windowed(seen), ...(seen.exits || []).map((exit) => cell(exit, "exit")), ...food.map((at) => cell(at, "food")),
      ...(seen.burning || []).map(([x, y]) => cell({x, y}, "burning"))];
    const self = [s("circle", {class: "self", cx: seen.x, cy: -seen.y, r: 1.2}), text(seen.x, seen.y - 0.45, seen.agent, "id")];
    const also = [`at ${number(seen.x)}, ${number(seen.y)}`, `${(seen.neighbours || []).length} near`, ...(seen.seen ? [`${far.length / 2} more seen`] : []), `${(seen.fires || []).length} fires`,
      ...(seen.energy == null ? [] : [`energy ${number(seen.energy)}`, `food in ${food.length} cells${here ? ", also in the agent's cell" : ""}`]), `${(seen.received || []).length} messages`];
    return h("div", {class: "map"}, s("svg", {viewBox: `${-size} ${-size} ${2 * size} ${2 * size}`, role: "img", "aria-label": `${label}: ${also.join(", ")}`},
      s("rect", {class: "field", x: -size + 1, y: -size + 1, width: 2 * size - 2, height: 2 * size - 2}), ...ground, ...zones, ...places, ...fires, ...far, ...others, ...self, ...food.map((at) => cell(at, "food-edge"))));
  };
})(window.Foundry);
