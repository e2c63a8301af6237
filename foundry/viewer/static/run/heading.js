"use strict";
/* The heading of a run: model, world, seed and score, with links to the next seed and to the next model. */
(function (foundry) {
  const {h, fill, number, quote} = foundry.dom;

  /** Return a link to the previous or next run in a list, at the same moment; nothing if there is none. */
  function arrow({sweep, id}, runs, by, sign, label) {
    const run = runs[runs.indexOf(id) + by], address = `#/run/${sweep}/${run}`;
    return run === undefined ? null : h("a", {class: "arrow", href: address, "aria-label": label, title: label,
      onclick: (event) => { event.currentTarget.hash = `${address}?${foundry.address.read()}`; }}, sign);
  }

  function arrows(data, what, runs) {
    return runs.length < 2 ? null : h("span", {class: "arrows"}, arrow(data, runs, -1, "◂", `Previous ${what}`), ` ${what} `, arrow(data, runs, 1, "▸", `Next ${what}`));
  }

  function scoreOf({score}) {
    return score && [` · score ${number(score.value)} `, h("small", {}, `${score.label} `, h("code", {}, score.measure), ` · model's mean ${number(score.mean)}, ${score.runs} seeds `)];
  }

  /** @param state the element for the status of the run */
  foundry.runHeading = (data, state) => {
    const {about} = data, {seeds, models} = about.beside, prompt = "prompt" in about.factors ? ` · ${about.prompt}` : "";
    const score = h("span", {class: "score"}), title = h("h1", {}, `${about.model} · ${about.world}${prompt} · seed ${about.seed}`, score);
    data.onAnalysis(() => fill(score, scoreOf(data.analysis)));
    return h("header", {class: "heading"}, title, arrows(data, "seed", seeds), arrows(data, "model", models), state,
      h("details", {class: "config"}, h("summary", {}, "configuration"), quote(JSON.stringify(about.config, null, 2), "small")));
  };
})(window.Foundry);
