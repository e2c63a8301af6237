"use strict";
/* Lists things that deserve attention: failed runs, unreadable replies, moments that show a finding, and runs far from the mean of their group. */
(function (foundry) {
  const {h, fill, grouped, number} = foundry.dom;
  const MOMENTS = 3, CAUSES = 20, NAMED = 5;

  class LookAt {
    /**
     * @param sweep the sweep's id
     * @param onUnread called with the row whose unreadable replies the user wants to see
     * @param nameOf returns the name of a run
     */
    constructor(sweep, onUnread, nameOf) {
      Object.assign(this, {sweep, onUnread, nameOf, again: ""});
      this.element = h("section", {class: "look-at", "aria-label": "Look at"});
    }

    async draw(runs, {findings, furthest}, rows) {
      const failed = runs.filter((run) => run.error);
      if (failed.length && foundry.source.live && !this.again) this.again = (await foundry.source.json(`sweep/${this.sweep}/underway`)).again;
      const parts = [this.failures(failed), this.unread(rows), this.moments(findings), this.far(furthest)].filter(Boolean);
      fill(this.element, h("h2", {}, "Look at"), parts.length ? parts : h("p", {class: "note"}, "No failed runs, unreadable replies or large differences so far."));
    }

    link(run, text = this.nameOf(run)) { return h("a", {href: `#/run/${this.sweep}/${run}`}, text); }

    failures(failed) {
      if (!failed.length) return null;
      const cause = ([text, runs]) => h("li", {}, h("b", {}, `${runs.length} × `), h("bdi", {}, text), " ",
        runs.slice(0, NAMED).map(({run}) => [this.link(run), " "]), runs.length > NAMED ? "…" : null);
      return [h("h3", {}, `Why runs failed (${failed.length})`), h("ul", {class: "failures"}, [...grouped(failed, (run) => run.error)].slice(0, CAUSES).map(cause)),
        this.again ? h("p", {}, "Play them again with ", h("code", {class: "again"}, this.again)) : null];
    }

    /** Show for each row the number of unreadable replies, with a link to them. */
    unread(rows) {
      const sum = (runs, key) => runs.reduce((total, run) => total + (run[key] || 0), 0);
      const having = rows.map(({name, runs}) => [name, sum(runs, "undecided"), sum(runs, "replies")]).filter(([, undecided]) => undecided).sort((a, b) => b[1] / b[2] - a[1] / a[2]);
      if (!having.length) return null;
      return [h("h3", {}, "Replies that could not be read"), h("ul", {class: "unread"}, having.map(([name, undecided, replies]) => h("li", {}, h("button", {type: "button", class: "go", disabled: !foundry.source.live,
        onclick: () => this.onUnread(name)}, `${name}: ${undecided.toLocaleString("en")} of ${replies.toLocaleString("en")} replies`))))];
    }

    moments(findings) {
      const moment = ({level_run: level, reference_run: reference, seed, step, agent}) => h("a", {
        href: `#/compare/${this.sweep}/${level}/${reference}?step=${step}&agent=${agent}`}, `an example: seed ${seed}, step ${step}, agent ${agent}`);
      const shown = findings.slice(0, MOMENTS);
      return shown.length ? [h("h3", {}, "Largest differences"), h("ul", {class: "findings"}, shown.map((row) =>
        h("li", {}, row.sentence, " ", h("span", {class: "note"}, `(${row.standing}) `), row.moments.length ? moment(row.moments[0]) : null)))] : null;
    }

    far(furthest) {
      return furthest.length ? [h("h3", {}, "Runs furthest from the mean of their group"), h("ul", {class: "far"}, furthest.map((row) =>
        h("li", {}, this.link(row.run), `: ${row.label} ${row.value}; mean of its group ${row.mean} `, h("small", {class: "note"}, `(${number(row.distance, 2)} standard deviations apart)`))))] : null;
    }
  }

  foundry.LookAt = LookAt;
})(window.Foundry);
