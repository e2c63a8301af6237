"use strict";
/* Shows the progress of a sweep: speed, estimated end, open runs, and failures with the command that plays them again. */
(function (foundry) {
  const {h, fill, badge, number, announce} = foundry.dom;
  const POLL_MS = 2000, LEAST_LOOKS = 5, KEPT = 150;
  const STANDINGS = ["complete", "failed", "running", "unfinished", "waiting"];

  /** Return how much a count grew per second in the last updates; null if there were too few updates. */
  function pace(looks, count) {
    if (looks.length < LEAST_LOOKS) return null;
    const first = looks[0], last = looks[looks.length - 1];
    return (count(last) - count(first)) / (last.at - first.at);
  }

  function span(seconds) {
    if (seconds < 90) return `${Math.round(seconds)} s`;
    return seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${number(seconds / 3600, 2)} h`;
  }

  /** Return the names of the models whose number of remaining calls is unknown. */
  function besides({unknown}) {
    const names = unknown.slice(0, 3).join(", ") + (unknown.length > 3 ? ` and ${unknown.length - 3} more` : "");
    return names && `, without the calls of ${names}, whose number is unknown`;
  }

  /** Return the time at which the remaining calls will be made if the speed does not change. */
  function end(found, looked, sent) {
    if (looked < found.runs) return "unknown until all runs have been read";
    if (found.left === null || !sent) return "not known yet";
    const seconds = found.left / sent, day = seconds > 18 * 3600 ? {weekday: "short", day: "numeric", month: "short"} : {};
    const clock = new Date((found.at + seconds) * 1000).toLocaleString("en-GB", {...day, hour: "2-digit", minute: "2-digit"});
    return `in ${span(seconds)} (${clock}), if the speed stays the same${besides(found)}`;
  }

  class Live {
    constructor(sweep) {
      this.sweep = sweep;
      this.looks = [];
      this.facts = h("div");
      this.runs = h("div", {class: "table-box", tabindex: "0", role: "region", "aria-label": "Open runs"});
      this.failures = h("section", {"aria-label": "Failed runs"});
      this.element = h("div", {class: "live"}, h("h1", {}, "Live progress"), this.facts, h("h2", {}, "Open runs"), this.runs, this.failures);
    }

    dispose() { this.disposed = true; }

    async open() {
      if (!foundry.source.live) throw new Error("This page consists of files only. Use `foundry view` or view=live to see the progress of a sweep.");
      await this.look();
      return this;
    }

    async look() {
      try {
        this.take(await foundry.source.json(`sweep/${this.sweep}/underway`));
      } catch (error) {
        if (!this.looks.length) throw error;
        fill(this.facts, h("p", {class: "warning"}, `The server does not answer: ${error.message}`));
      }
      setTimeout(() => this.disposed || this.look(), POLL_MS);
    }

    take(found) {
      const before = this.looks[this.looks.length - 1];
      if (before && found.calls < before.calls) this.looks = []; // another session counts from 0
      if (!before || found.at > before.at) this.looks = [...this.looks, found].slice(-KEPT);
      this.draw(found);
    }

    draw(found) {
      const {counts} = found, looked = Object.values(counts).reduce((a, b) => a + b, 0), ended = (counts.complete || 0) + (counts.failed || 0);
      const sent = pace(this.looks, (one) => one.calls - one.cached), tokens = pace(this.looks, (one) => one.output_tokens);
      const rate = (perSecond, what) => (perSecond === null ? "not known yet" : `${number(perSecond)} ${what} per second`);
      const busy = found.workers > 0;
      fill(this.facts, h("div", {class: "progress"}, h("progress", {max: String(found.runs), value: String(ended), "aria-label": "Runs that have ended"}),
        h("span", {}, `${number(ended)} of ${number(found.runs)} runs ended`), looked < found.runs ? h("span", {}, `(${number(looked)} read so far)`) : null,
        STANDINGS.filter((word) => counts[word]).map((word) => h("span", {}, badge(word), ` ${number(counts[word])}`))),
      foundry.parts.facts([
        ["workers", busy ? number(found.workers) : "none; this sweep is not running"],
        ["calls", busy ? `${number(found.calls)} made in this session${found.left === null ? "" : `, about ${number(Math.round(found.left))} left${besides(found)}`}` : null],
        ["from the cache", found.calls ? `${number(100 * found.cached / found.calls)} % of the calls` : null],
        ["speed", busy ? rate(sent, "calls sent") : null], ["output", busy ? rate(tokens, "tokens received") : null],
        ["retries", busy ? number(found.retries) : null],
        ["queue", found.allowed ? `${number(found.wanted)} calls sent or waiting; at most ${number(found.allowed)} at a time` : null],
        ["estimated end", busy ? end(found, looked, sent) : null],
      ]), found.notes.map((line) => h("p", {class: "note"}, line)));
      this.drawRuns(found);
      this.drawFailures(found);
    }

    drawRuns(found) {
      const heads = ["run", "model", "prompt", "seed", "step", "calls", "cached", "retries", "tokens out"];
      const of = (done, all) => `${number(done)}${all === null || all === undefined ? "" : ` of ${number(all)}`}`;
      const row = (one) => h("tr", {"data-run": one.run}, h("th", {scope: "row"}, h("a", {href: `#/run/${this.sweep}/${one.run}`}, one.run)),
        [one.model, one.prompt, String(one.seed)].map((text) => h("td", {}, text)),
        [of(one.done, one.planned), of(one.calls, one.expected), number(one.cached), number(one.retries), number(one.output_tokens)].map((text) => h("td", {class: "number"}, text)));
      fill(this.runs, found.open.length ? h("table", {class: "runs"}, h("caption", {class: "unseen"}, "Open runs"),
        h("thead", {}, h("tr", {}, heads.map((name, index) => h("th", {scope: "col", class: index > 3 ? "number" : null}, name)))), h("tbody", {}, found.open.map(row)))
        : h("p", {class: "note"}, "No run is open."), found.open_runs > found.open.length ? h("p", {class: "note"}, `and ${number(found.open_runs - found.open.length)} more`) : null);
    }

    drawFailures(found) {
      const total = found.counts.failed || 0, text = JSON.stringify([total, found.failures]), more = found.causes - found.failures.length;
      if (text === this.failed) return;
      this.failed = text;
      if (total) announce(`${total} runs failed.`);
      fill(this.failures, total ? [h("h2", {}, `Failed runs (${number(total)})`), h("p", {}, "Play them again with ", h("code", {class: "again"}, found.again)),
        h("ul", {}, found.failures.map((one) => h("li", {}, h("b", {}, `${number(one.count)} × ${one.error_type || "Error"}: `), h("bdi", {}, one.error || ""), " ",
          one.runs.map((run) => [h("a", {href: `#/run/${this.sweep}/${run}`}, run), " "]), one.count > one.runs.length ? "…" : null))), more ? h("p", {class: "note"}, `and ${number(more)} further causes`) : null] : null);
    }
  }

  foundry.Live = Live;
})(window.Foundry);
