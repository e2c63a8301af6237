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
  function end(load, looked, sent) {
    if (looked < load.runs) return "unknown until all runs have been read";
    if (load.left === null || !sent) return "not known yet";
    const seconds = load.left / sent, day = seconds > 18 * 3600 ? {weekday: "short", day: "numeric", month: "short"} : {};
    const clock = new Date((load.at + seconds) * 1000).toLocaleString("en-GB", {...day, hour: "2-digit", minute: "2-digit"});
    return `in ${span(seconds)} (${clock}), if the speed stays the same${besides(load)}`;
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

    take(load) {
      const before = this.looks[this.looks.length - 1];
      if (before && load.calls < before.calls) this.looks = []; // another session counts from 0
      if (!before || load.at > before.at) this.looks = [...this.looks, load].slice(-KEPT);
      this.draw(load);
    }

    draw(load) {
      const {counts} = load, looked = Object.values(counts).reduce((a, b) => a + b, 0), ended = (counts.complete || 0) + (counts.failed || 0);
      const sent = pace(this.looks, (look) => look.calls - look.cached), tokens = pace(this.looks, (look) => look.output_tokens);
      const rate = (perSecond, what) => (perSecond === null ? "not known yet" : `${number(perSecond)} ${what} per second`);
      const busy = load.workers > 0;
      fill(this.facts, h("div", {class: "progress"}, h("progress", {max: String(load.runs), value: String(ended), "aria-label": "Runs that have ended"}),
        h("span", {}, `${number(ended)} of ${number(load.runs)} runs ended`), looked < load.runs ? h("span", {}, `(${number(looked)} read so far)`) : null,
        STANDINGS.filter((word) => counts[word]).map((word) => h("span", {}, badge(word), ` ${number(counts[word])}`))),
      foundry.parts.facts([
        ["workers", busy ? number(load.workers) : "none; this sweep is not running"],
        ["calls", busy ? `${number(load.calls)} made in this session${load.left === null ? "" : `, about ${number(Math.round(load.left))} left${besides(load)}`}` : null],
        ["from the cache", load.calls ? `${number(100 * load.cached / load.calls)} % of the calls` : null],
        ["speed", busy ? rate(sent, "calls sent") : null], ["output", busy ? rate(tokens, "tokens received") : null],
        ["retries", busy ? number(load.retries) : null],
        ["queue", load.allowed ? `${number(load.wanted)} calls sent or waiting; at most ${number(load.allowed)} at a time` : null],
        ["estimated end", busy ? end(load, looked, sent) : null],
      ]), load.notes.map((line) => h("p", {class: "note"}, line)));
      this.drawRuns(load);
      this.drawFailures(load);
    }

    drawRuns(load) {
      const heads = ["run", "model", "prompt", "seed", "step", "calls", "cached", "retries", "tokens out"];
      const of = (done, all) => `${number(done)}${all === null || all === undefined ? "" : ` of ${number(all)}`}`;
      const row = (run) => h("tr", {"data-run": run.run}, h("th", {scope: "row"}, h("a", {href: `#/run/${this.sweep}/${run.run}`}, run.run)),
        [run.model, run.prompt, String(run.seed)].map((text) => h("td", {}, text)),
        [of(run.done, run.planned), of(run.calls, run.expected), number(run.cached), number(run.retries), number(run.output_tokens)].map((text) => h("td", {class: "number"}, text)));
      fill(this.runs, load.open.length ? h("table", {class: "runs"}, h("caption", {class: "unseen"}, "Open runs"),
        h("thead", {}, h("tr", {}, heads.map((name, index) => h("th", {scope: "col", class: index > 3 ? "number" : null}, name)))), h("tbody", {}, load.open.map(row)))
        : h("p", {class: "note"}, "No run is open."), load.open_runs > load.open.length ? h("p", {class: "note"}, `and ${number(load.open_runs - load.open.length)} more`) : null);
    }

    drawFailures(load) {
      const total = load.counts.failed || 0, text = JSON.stringify([total, load.failures]), more = load.causes - load.failures.length;
      if (text === this.failed) return;
      this.failed = text;
      if (total) announce(total === 1 ? "1 run failed." : `${total} runs failed.`);
      fill(this.failures, total ? [h("h2", {}, `Failed runs (${number(total)})`), h("p", {}, "Play them again with ", h("code", {class: "again"}, load.again)),
        h("ul", {}, load.failures.map((cause) => h("li", {}, h("b", {}, `${number(cause.count)} × ${cause.error_type || "Error"}: `), h("bdi", {}, cause.error || ""), " ",
          cause.runs.map((run) => [h("a", {href: `#/run/${this.sweep}/${run}`}, run), " "]), cause.count > cause.runs.length ? "…" : null))), more ? h("p", {class: "note"}, `and ${number(more)} further causes`) : null] : null);
    }
  }

  foundry.Live = Live;
})(window.Foundry);
