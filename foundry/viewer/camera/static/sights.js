"use strict";
/* The position of the target in the images of a 3D run, as the server computes it: loaded by chunks, drawn, and described in words. */
(function (foundry) {
  const {h, badge, number} = foundry.dom;
  const INK = "#10161d", SEEN = "#4dffa6", ELSEWHERE = "#ffd24d", PAPER = "#ffffff";
  const SMALL = 16, EDGE = 16, HEAD = 9, LINE = 2, FONT = 12, TAU = 2 * Math.PI;
  const LEVEL = 5;

  /** Return the effect of a command, in words. */
  function command(value) {
    const parts = [], given = (value) => value !== null && value !== undefined;
    if (value.translate) parts.push(`move ${number(value.translate.distance)} m ${bearing(value.translate.bearing)}`);
    if (given(value.turn)) parts.push(`turn ${aside(value.turn)}`);
    if (given(value.gaze)) parts.push(`look ${number(Math.abs(value.gaze))}° ${value.gaze < 0 ? "down" : "up"}`);
    if (value.stay) parts.push("stay");
    if (given(value.answer)) parts.push(`answer ${value.answer}`);
    return parts.join(", ") || "nothing";
  }

  function bearing(degrees) {
    const named = {0: "forward", 90: "left", "-90": "right", 180: "back", "-180": "back"}[degrees];
    return named || `${aside(degrees)} of ahead`;
  }

  function aside(degrees) { return `${number(Math.abs(degrees))}° ${degrees < 0 ? "right" : "left"}`; }

  /** Return the direction of the target's centre from the gaze, in words. */
  function direction({turn, tilt}) {
    const parts = [];
    if (Math.abs(turn) > LEVEL) parts.push(aside(Math.round(turn)));
    if (Math.abs(tilt) > LEVEL) parts.push(`${Math.abs(Math.round(tilt))}° ${tilt < 0 ? "down" : "up"}`);
    return parts.join(", ") || "ahead";
  }

  /** Return the position of the target, in words. Without data from the server, use only the record. */
  function place(record, sight) {
    const sees = record.line_of_sight ? "in line of sight" : "no line of sight";
    if (record.target_visible_px) return `${number(record.target_visible_px)} px in view, ${sees}`;
    if (!sight?.place) return `not in view, ${sees}`;
    if (sight.place === "hidden") return `hidden, ${direction(sight)}, ${record.line_of_sight ? "in line of sight, outside the picture" : "behind something"}`;
    return `not in the picture, ${direction(sight)}, ${record.line_of_sight ? "nothing in between" : "behind something"}`;
  }

  /** Return the reading of a reply and the visibility of the target, one line each. */
  function reading(record, sight, target) {
    const line = (...parts) => h("span", {class: "line"}, parts), lines = [line(badge(record.outcome), ` read as: ${command(record.command)}`)];
    if (!target || record.question) return lines;
    lines.push(h("span", {class: "line place"}, `${target}: ${place(record, sight)}`));
    const untrue = sight?.claimed && !record.target_visible_px;
    if (sight?.claimed) lines.push(line(h("b", {class: untrue ? "tone-bad" : null}, "claims to see the target", untrue ? ", but the target is not in view" : "")));
    else if (sight?.claimed === false) lines.push(line("does not claim to see the target"));
    return lines;
  }

  /** Store the facts of an episode, which are loaded with its steps. */
  async function begin(data) {
    if (data.done && !data.about.episode) data.about = await foundry.source.json(`${data.address}/about`);
  }

  /** The sights of a run by chunks of steps. */
  class Sights {
    constructor(data) {
      this.data = data;
      this.chunks = new Map();
    }

    /**
     * Return {sight, target, why} of a step. `sight` holds the target's place in the scene; `why` is the reason if
     * nothing can be marked.
     */
    async at(step) {
      await begin(this.data);
      const {data} = this, size = data.about.steps_per_chunk, number = data.numberOf(step, size), key = `${data.progress.beginning}/${number}`;
      let chunk = this.chunks.get(key);
      if (!chunk || !data.isWhole(chunk, number, size)) {
        chunk = await data.once(`sights/${number}`);
        this.chunks.set(key, chunk);
      }
      return {sight: chunk.sights[step - chunk.first] || null, target: chunk.target, why: chunk.why};
    }
  }

  /** Stroke the outline that `trace` draws, so that it is visible on light and on dark pictures. */
  function stroke(pen, colour, trace) {
    for (const [style, width] of [[INK, LINE + 2], [colour, LINE]]) {
      pen.strokeStyle = style;
      pen.lineWidth = width;
      pen.beginPath();
      trace();
      pen.stroke();
    }
  }

  function fits(value, low, high) { return Math.max(low, Math.min(value, high)); }

  /** Write the first text that fits, on a dark background, as near to a point as the edges of the picture allow. */
  function label(pen, texts, colour, {x, y, width, height}) {
    pen.font = `600 ${FONT}px system-ui, sans-serif`;
    const text = texts.find((text) => pen.measureText(text).width + 8 <= width), tall = FONT + 6;
    if (text === undefined) return;
    const wide = pen.measureText(text).width + 8;
    const left = fits(x - wide / 2, 0, width - wide), top = fits(y - tall / 2, 0, height - tall);
    pen.fillStyle = INK;
    pen.fillRect(left, top, wide, tall);
    pen.fillStyle = colour;
    pen.textBaseline = "middle";
    pen.fillText(text, left + 4, top + tall / 2 + 1);
  }

  function cross(pen, colour, x, y, size) {
    stroke(pen, colour, () => {
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        pen.moveTo(x + 0.35 * size * dx, y + 0.35 * size * dy);
        pen.lineTo(x + size * dx, y + size * dy);
      }
    });
  }

  /**
   * Mark a target inside the picture with a box, or with a cross if the box would be too small; broken lines if the
   * target is hidden.
   */
  function markInside(pen, {sight, name, width, height}) {
    const colour = sight.place === "seen" ? SEEN : ELSEWHERE;
    pen.setLineDash(sight.place === "seen" ? [] : [4, 4]);
    const boxes = sight.boxes.map(([[left, top], [right, bottom]]) => ({x: left * width, y: top * height, w: (right - left) * width, h: (bottom - top) * height}));
    for (const {x, y, w, h} of boxes) {
      if (Math.max(w, h) < SMALL) cross(pen, colour, x + w / 2, y + h / 2, SMALL);
      else stroke(pen, colour, () => pen.rect(x, y, w, h));
    }
    pen.setLineDash([]);
    if (sight.spot) stroke(pen, colour, () => pen.arc(sight.spot[0] * width, sight.spot[1] * height, 1, 0, TAU));
    const [first] = boxes, room = SMALL + FONT;
    const y = first.y > room ? first.y - FONT : first.y + Math.max(first.h, SMALL) + FONT;
    label(pen, sight.place === "seen" ? [name] : [`${name}: hidden`, "hidden"], colour, {x: first.x + first.w / 2, y, width, height});
  }

  /** Mark the direction of the target at the edge of the picture. */
  function markOutside(pen, {sight, name, record, width, height}) {
    const length = Math.hypot(sight.turn, sight.tilt) || 1, dx = -sight.turn / length, dy = -sight.tilt / length;
    const far = Math.min(dx ? (width / 2 - EDGE) / Math.abs(dx) : Infinity, dy ? (height / 2 - EDGE) / Math.abs(dy) : Infinity);
    const x = width / 2 + far * dx, y = height / 2 + far * dy, angle = Math.atan2(dy, dx);
    const corner = (turn, size) => [x + size * Math.cos(angle + turn), y + size * Math.sin(angle + turn)];
    stroke(pen, ELSEWHERE, () => {
      pen.moveTo(...corner(TAU / 2.6, HEAD));
      pen.lineTo(...corner(0, HEAD));
      pen.lineTo(...corner(-TAU / 2.6, HEAD));
      pen.moveTo(...corner(0, HEAD));
      pen.lineTo(...corner(TAU / 2, 1.6 * HEAD));
    });
    const way = direction(sight), texts = [`${name} ${way}`, way];
    if (!record.line_of_sight) texts.unshift(`${name} ${way}, behind something`);
    const below = Math.abs(dx) > Math.abs(dy) || dy < 0;
    label(pen, texts, ELSEWHERE, {x, y: y + (below ? 1 : -1) * (HEAD + FONT + 2), width, height});
  }

  /** Draw the marks of a picture of this size, in CSS pixels. */
  function mark(pen, {record, sight, name, width, height}) {
    if (!sight?.place) return;
    const all = {record, sight, name, width, height};
    if (sight.place === "outside") markOutside(pen, all);
    else if (sight.boxes.length) markInside(pen, all);
  }

  foundry.camera = {begin, command, reading, mark, Sights};
})(window.Foundry);
