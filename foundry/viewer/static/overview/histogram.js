"use strict";
/* How the values of a column are spread over the runs, in its head; a range of them leaves its runs in the table. */
(function (foundry) {
  const {h, s, number} = foundry.dom;
  const BARS = 20, WIDTH = 80, HEIGHT = 18, KEY = "range.";

  /** Return the ranges that an address asks for, by the key of a column: the lowest and the highest value. */
  function rangesOf(query) {
    const asked = [...query].filter(([key]) => key.startsWith(KEY)).map(([key, text]) => [key.slice(KEY.length), text.split(",").map(Number)]);
    return new Map(asked.filter(([, range]) => range.length === 2 && range.every(Number.isFinite)));
  }

  function ofAll(values, choose, start) { return values.reduce((a, b) => choose(a, b), start); }

  /** Return where values fall: `at` returns the bar of a value, `middle` the value in the middle of a bar; null where all are alike. */
  function scaleOf(values) {
    const low = ofAll(values, Math.min, Infinity), high = ofAll(values, Math.max, -Infinity);
    if (!(high > low)) return null;
    const whole = high - low < BARS && values.every(Number.isInteger), bars = whole ? high - low + 1 : BARS, width = (high - low) / (whole ? bars - 1 : bars);
    const at = (value) => Math.max(0, Math.min(bars - 1, Math.floor((value - low) / width)));
    return {low, high, bars, at, middle: (bar) => low + (bar + (whole ? 0 : 0.5)) * width};
  }

  class Histograms {
    /** @param onChange called with what the address is to say, and whether Back is to undo it */
    constructor(onChange) {
      this.onChange = onChange;
      this.spreads = new WeakMap();
      this.moved = {};
    }

    /** Return the numbers of a column and how they are spread; counted once for the same rows. */
    spread(column, rows) {
      if (!this.spreads.has(rows)) this.spreads.set(rows, new Map());
      const known = this.spreads.get(rows);
      if (!known.has(column.key)) {
        const values = rows.map(column.value).filter((value) => typeof value === "number"), scale = scaleOf(values);
        known.set(column.key, {values, scale, counts: scale && this.counts(values, scale)});
      }
      return known.get(column.key);
    }

    counts(values, {bars, at}) {
      const counts = new Array(bars).fill(0);
      values.forEach((value) => { counts[at(value)] += 1; });
      return counts;
    }

    /**
     * Draw a column: all runs pale, those that are in the table dark, the chosen range framed.
     * @param range the lowest and the highest value that is chosen, or undefined
     */
    element(column, rows, shown, range) {
      const {values, scale, counts} = this.spread(column, rows);
      if (!scale) return null;
      const inTable = this.counts(shown.map(column.value).filter((value) => typeof value === "number"), scale), most = ofAll(counts, Math.max, 1);
      const chosen = this.chosen(column.key, scale, range), wide = WIDTH / scale.bars;
      const bar = (name) => (count, index) => (count ? s("rect", {class: name, x: index * wide, width: wide, y: HEIGHT * (1 - count / most), height: (HEIGHT * count) / most}) : null);
      const leave = (bars, push) => this.leave(column.key, bars, values, scale, push);
      return h("div", {class: "histogram", tabindex: "0", role: "application", "aria-label": `Values of ${column.label}`,
        "aria-description": `${number(scale.low)} to ${number(scale.high)}${range ? `, chosen ${range.map((one) => number(one)).join(" to ")}` : ""}; arrows choose a range`,
        title: `${number(scale.low)} to ${number(scale.high)}`,
        onpointerdown: (event) => { this.from = {key: column.key, bar: barAt(event, scale)}; },
        onpointerup: (event) => this.dragged(column.key, barAt(event, scale), chosen, leave),
        onkeydown: (event) => this.key(event, column.key, chosen, scale, leave)},
      s("svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, width: WIDTH, height: HEIGHT, "aria-hidden": "true"}, counts.map(bar("all")), inTable.map(bar("matching")),
        chosen ? s("rect", {class: "chosen", x: chosen[0] * wide, y: 0, width: (chosen[1] - chosen[0] + 1) * wide, height: HEIGHT}) : null));
    }

    /** Return the first and the last bar of a range; where keys moved it, those that they moved it to. */
    chosen(key, scale, range) {
      if (!range) return null;
      const {moved} = this;
      return moved.key === key && moved.text === range.join() ? moved.bars : range.map(scale.at);
    }

    /** Leave the runs of some bars: the range is that of the values in them, so that it holds the same ones however bars are drawn. */
    leave(key, bars, values, scale, push) {
      const held = values.filter((value) => scale.at(value) >= bars[0] && scale.at(value) <= bars[1]);
      const range = held.length ? [ofAll(held, Math.min, Infinity), ofAll(held, Math.max, -Infinity)] : bars.map(scale.middle);
      this.moved = {key, bars, text: range.join()};
      this.onChange({[KEY + key]: range.join(), page: null}, push);
    }

    clear(key) { this.onChange({[KEY + key]: null, page: null}); }

    /** Choose the bars that were dragged over; a click on the only one that is chosen ends the choice. */
    dragged(key, bar, chosen, leave) {
      const {from} = this;
      this.from = null;
      if (from?.key !== key) return;
      if (from.bar === bar && chosen && chosen[0] === bar && chosen[1] === bar) this.clear(key);
      else leave([Math.min(from.bar, bar), Math.max(from.bar, bar)], true);
    }

    /** Arrows move the range, with Shift its upper end; the first one chooses the middle half, Escape ends it. */
    key(event, key, chosen, {bars}, leave) {
      const by = {ArrowLeft: -1, ArrowRight: 1}[event.key];
      if (event.key === "Escape" && chosen) this.clear(key);
      else if (by && !chosen) leave([Math.floor(bars / 4), Math.ceil((3 * bars) / 4) - 1], true);
      else if (by && event.shiftKey) leave([chosen[0], Math.max(chosen[0], Math.min(bars - 1, chosen[1] + by))], false);
      else if (by) leave(chosen.map((one) => one + Math.max(-chosen[0], Math.min(bars - 1 - chosen[1], by))), false);
      else return;
      event.preventDefault();
    }

    /** Return what tells the chosen ranges, and ends each. */
    buttons(ranges) {
      return [...ranges].map(([key, [low, high]]) => h("button", {type: "button", "aria-label": `Every ${key}`, onclick: () => this.clear(key)}, `${key} ${number(low)} to ${number(high)} ✕`));
    }
  }

  function barAt(event, {bars}) {
    const {left, width} = event.currentTarget.firstChild.getBoundingClientRect();
    return Math.max(0, Math.min(bars - 1, Math.floor(((event.clientX - left) / width) * bars)));
  }

  Histograms.rangesOf = rangesOf;
  foundry.Histograms = Histograms;
})(window.Foundry);
