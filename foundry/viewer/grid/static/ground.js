"use strict";
/* Draws the ground of a 2D world: the field with walls, exits, food and flames, places, fires, and their names. */
(function (foundry) {
  /** Height of the names on the map, px. */
  const LETTERS = 12;
  /** Smallest distance between an agent's centre and a name, px, at which the agent does not hide the name. */
  const NEAR = 9;
  const TAU = 2 * Math.PI;

  /** A part of `Grid`, which holds the data, the step, the scale and the colours. */
  class Ground {
    drawField(pen) {
      this.labels = [];
      this.flames = [];
      const half = this.about.half_size + 0.5, {cell, tones} = this;
      const left = this.toX(-half), top = this.toY(half), size = 2 * half * cell;
      if (cell >= 6) {
        pen.beginPath();
        for (let line = -half; line <= half; line += 1) {
          pen.moveTo(this.toX(line), top); pen.lineTo(this.toX(line), top + size);
          pen.moveTo(left, this.toY(line)); pen.lineTo(left + size, this.toY(line));
        }
        pen.globalAlpha = 0.35;
        pen.lineWidth = 1;
        pen.strokeStyle = tones.line;
        pen.stroke();
        pen.globalAlpha = 1;
      }
      pen.strokeStyle = tones.soft;
      pen.lineWidth = 1.5;
      pen.strokeRect(left, top, size, size);
    }

    /** Draw food and burning cells at this step of the run. */
    drawChanging(pen) {
      const {about, tones, chunk, step} = this;
      if (!chunk || step < chunk.first || step > chunk.last) return;
      if (chunk.food) {
        const full = (about.food && about.food.amount) || 1;
        for (const [cell, amount] of this.cellsOf(chunk.food, step - chunk.first + (this.share < 1 ? 0 : 1))) {
          if (amount) this.fill(pen, ...cell.split(",").map(Number), tones.place, 0.1 + 0.4 * amount / full);
        }
      }
      if (chunk.burning) {
        for (const [cell] of this.cellsOf(chunk.burning, step - chunk.first + 1)) this.fill(pen, ...cell.split(",").map(Number), tones.fire, 0.5);
      }
    }

    /** Draw zones, walls and exits, if the world has any. */
    drawFurniture(pen) {
      const {about, tones} = this;
      for (const zone of about.zones || []) this.fillRectangle(pen, zone.corners, tones.bad, 0.15);
      for (const wall of about.walls || []) this.fillRectangle(pen, wall, tones.soft, 1);
      for (const way of about.exits || []) {
        for (const [x, y] of way.cells) this.fill(pen, x, y, tones.talk, 0.85);
        const [x, y] = [this.toX(way.cells[0][0]), this.toY(way.cells[0][1])];
        this.labels.push({text: way.name, tone: tones.ink, spots: [[x, y - 8, 0.5], [x, y + 18, 0.5], [x + 10, y + 4, 0], [x - 10, y + 4, 1]]});
      }
    }

    /** Return [cell, amount] of all cells that have changed up to an entry in a list of changes. */
    cellsOf(changes, upTo) {
      const cells = new Map();
      for (const change of changes.slice(0, upTo + 1)) {
        for (let index = 0; index < change.length; index += 3) cells.set(`${change[index]},${change[index + 1]}`, change[index + 2]);
      }
      return cells;
    }

    fill(pen, x, y, tone, alpha) { this.fillRectangle(pen, [[x, y], [x, y]], tone, alpha); }

    fillRectangle(pen, [[x, y], [otherX, otherY]], tone, alpha) {
      const left = this.toX(Math.min(x, otherX) - 0.5), top = this.toY(Math.max(y, otherY) + 0.5);
      pen.globalAlpha = alpha;
      pen.fillStyle = tone;
      pen.fillRect(left, top, (Math.abs(otherX - x) + 1) * this.cell, (Math.abs(otherY - y) + 1) * this.cell);
      pen.globalAlpha = 1;
    }

    drawPlaces(pen, chunk, base) {
      const {tones, about} = this, inside = this.countInside(chunk, base);
      about.places.forEach((place, index) => {
        const over = inside[index] > place.capacity;
        this.drawPlace(pen, place, over ? tones.bad : tones.place, `${place.name} ${inside[index]}/${place.capacity}${over ? " over" : ""}`, Math.min(1, inside[index] / place.capacity));
      });
    }

    /** Draw a place; `full` is the used share of its capacity. */
    drawPlace(pen, place, tone, text, full = 0) {
      const left = this.toX(place.center[0] - place.extent[0] - 0.5), top = this.toY(place.center[1] + place.extent[1] + 0.5);
      const width = (2 * place.extent[0] + 1) * this.cell, height = (2 * place.extent[1] + 1) * this.cell, middle = left + width / 2;
      pen.fillStyle = pen.strokeStyle = tone;
      pen.globalAlpha = 0.14;
      pen.fillRect(left, top, width, height);
      pen.globalAlpha = 0.5;
      pen.fillRect(left, top + height - 4, width * full, 4);
      pen.globalAlpha = 1;
      pen.lineWidth = 1.5;
      pen.strokeRect(left, top, width, height);
      this.labels.push({text, tone: tone === this.tones.bad ? tone : this.tones.ink,
        spots: [[middle, top - 5, 0.5], [middle, top + height + 14, 0.5], [left + width + 5, top + 12, 0], [left - 5, top + 12, 1], [middle, top + 14, 0.5]]});
    }

    /** Return the number of agents in each place; at the end of the step, by their new positions. */
    countInside(chunk, base) {
      const {about} = this, inside = new Array(about.places.length).fill(0);
      for (let agent = base; agent < base + about.agents; agent += 1) {
        const place = this.share < 1 ? chunk.place[agent] : this.placeOf(chunk.x[agent + about.agents], chunk.y[agent + about.agents]);
        if (place >= 0) inside[place] += 1;
      }
      return inside;
    }

    placeOf(x, y) {
      return this.about.places.findIndex(({center, extent}) => Math.abs(x - center[0]) <= extent[0] && Math.abs(y - center[1]) <= extent[1]);
    }

    /**
     * Write each name at the first of its spots, [x, y, share of it to the left], that is visible and free of other names and,
     * if possible, of agents. If no spot is free, leave the name out.
     */
    drawLabels(pen) {
      const taken = [...this.flames], agents = this.chunk ? this.spots || [] : [];
      const hides = (box) => agents.some(([x, y]) => x > box.left - NEAR && x < box.right + NEAR && y > box.top - NEAR && y < box.bottom + NEAR);
      pen.font = `600 ${LETTERS}px system-ui, sans-serif`;
      for (const {text, tone, spots} of this.labels) {
        const width = pen.measureText(text).width;
        const boxes = spots.map(([x, y, before]) => ({left: x - before * width, right: x + (1 - before) * width, top: y - LETTERS, bottom: y + 3}));
        const free = boxes.filter((box) => box.left > 1 && box.right < this.width - 1 && box.top > 1 && box.bottom < this.height - 1
          && taken.every((other) => box.right < other.left || box.left > other.right || box.bottom < other.top || box.top > other.bottom));
        if (!free.length) continue;
        const box = free.find((box) => !hides(box)) || free[0];
        taken.push(box);
        pen.fillStyle = this.tones.paper;
        pen.globalAlpha = 0.8;
        pen.fillRect(box.left - 2, box.top, width + 4, box.bottom - box.top);
        pen.globalAlpha = 1;
        pen.fillStyle = tone;
        pen.fillText(text, box.left, box.bottom - 3);
      }
    }

    drawFires(pen) {
      const {tones} = this;
      for (const fire of this.about.fires || []) {
        const burning = this.step >= fire.start, x = this.toX(fire.position[0]), y = this.toY(fire.position[1]);
        pen.beginPath();
        pen.arc(x, y, Math.max(2, fire.radius * this.cell), 0, TAU);
        pen.fillStyle = tones.fire;
        pen.strokeStyle = tones.fire;
        pen.globalAlpha = burning ? 0.06 + 0.12 * fire.intensity : 0;
        pen.fill();
        pen.globalAlpha = burning ? 0.9 : 0.35;
        pen.lineWidth = 1.5;
        pen.setLineDash(burning ? [] : [4, 6]);
        pen.stroke();
        pen.setLineDash([]);
        if (burning) this.flame(pen, x, y);
        pen.globalAlpha = 1;
        this.labels.push({text: burning ? fire.name : `${fire.name} from step ${fire.start}`, tone: tones.fire,
          spots: [[x + 11, y + 4, 0], [x - 11, y + 4, 1], [x, y - 12, 0.5], [x, y + 21, 0.5]]});
      }
    }

    flame(pen, x, y) {
      this.flames.push({left: x - 7, right: x + 7, top: y - 8, bottom: y + 8});
      pen.beginPath();
      pen.moveTo(x, y - 9);
      pen.bezierCurveTo(x + 9, y - 1, x + 6, y + 8, x, y + 8);
      pen.bezierCurveTo(x - 6, y + 8, x - 9, y - 1, x, y - 9);
      pen.fill();
    }
  }

  foundry.GridGround = Ground;
})(window.Foundry);
