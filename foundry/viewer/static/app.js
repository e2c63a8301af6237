"use strict";
/* Chooses the page by the part of the address after #. */
(function (foundry) {
  const {h, fill, badge} = foundry.dom;
  let current = null;
  let turn = 0;
  let shown = null;
  const lastOverview = new Map();
  const PROBE = ["probe/moment.js", "probe/moments.js"];

  /** Show the status of a run, and whether the server still answers. */
  foundry.showState = (element, data) => fill(element, badge(data.progress.status),
    data.lost ? h("span", {class: "note"}, " the server does not answer; this page shows the last data that it received") : null,
    data.progress.error ? h("span", {class: "warning"}, `${data.progress.error_type || "Error"}: ${data.progress.error}`) : null);

  function crumbs(parts) {
    fill(document.getElementById("crumbs"), parts.map(([text, address]) =>
      ["› ", address ? h("a", {href: address}, text) : h("span", {"aria-current": "page"}, text), " "]));
  }

  async function runPage([sweep, run], query) {
    const data = await new foundry.RunData(sweep, run).open();
    crumbs([[sweep, lastOverview.get(sweep) || `#/sweep/${sweep}`], [run, null]]);
    const agent = query.get("agent");
    const page = data.form.page(data, {step: Number(query.get("step")) || null, agent: agent === null ? null : Number(agent), camera: query.get("camera")});
    data.follow(() => page.disposed);
    data.loadAnalysis();
    return page;
  }

  /** Largest number of runs in a comparison; the page names the other runs. */
  const COMPARED = 12;

  async function comparePage([sweep, ...asked], query) {
    const runs = [...new Set(asked)], tried = await Promise.allSettled(runs.slice(0, COMPARED).map((run) => new foundry.RunData(sweep, run).open()));
    const open = tried.filter((load) => load.status === "fulfilled").map((load) => load.value);
    if (!open.length) throw tried[0]?.reason || new Error("No runs to compare: tick runs in the table.");
    const left = runs.map((run, index) => ({run, why: index < COMPARED ? tried[index].reason?.message : `this page shows at most ${COMPARED} runs`})).filter((run) => run.why);
    crumbs([[sweep, lastOverview.get(sweep) || `#/sweep/${sweep}`], [`${open.length} runs side by side`, null]]);
    const agent = query.get("agent");
    const page = new foundry.ComparePage(open, {step: Number(query.get("step")) || null, agent: agent === null ? null : Number(agent)}, left);
    open.forEach((data) => data.follow(() => page.disposed));
    return page;
  }

  async function sweepOf(wanted) {
    const {sweeps, unreadable} = await foundry.source.json("sweeps");
    const sweep = wanted ? sweeps.find((sweep) => sweep.id === wanted) : sweeps[0];
    if (!sweep) throw new Error(`There is no sweep '${wanted}'. Available: ${sweeps.map((sweep) => sweep.id).join(", ")}.`);
    return {sweeps, sweep, unreadable};
  }

  function overview({sweeps, sweep, unreadable}, query) {
    crumbs(sweep.probe ? [[sweep.name, `#/sweep/${sweep.id}`], ["runs", null]] : [[sweep.name, null]]);
    return new foundry.Overview(sweeps, sweep, unreadable, query).open();
  }

  async function runsPage([wanted], query) { return overview(await sweepOf(wanted), query); }

  async function livePage([sweep]) {
    const page = await new foundry.Live(sweep).open();
    crumbs([[sweep, lastOverview.get(sweep) || `#/sweep/${sweep}`], ["live progress", null]]);
    return page;
  }

  /** A probe opens with its moments if a moment has answers; other sweeps open with their runs. */
  async function sweepPage([wanted], query) {
    const asked = await sweepOf(wanted);
    if (!asked.sweep.probe) return overview(asked, query);
    for (const address of PROBE) await foundry.script(address);
    const page = await new foundry.MomentsPage(asked, query).open();
    if (!page.isAnswered()) { page.dispose(); return overview(asked, query); }
    crumbs([[asked.sweep.name, null]]);
    return page;
  }

  const PAGES = {run: runPage, compare: comparePage, live: livePage, runs: runsPage, sweep: sweepPage, "": sweepPage};

  /** Return the page for the address. */
  async function asked() {
    const [path, query] = location.hash.replace(/^#\/?/, "").split("?");
    const [kind, ...rest] = path.split("/").map(decoded);
    if (!Object.hasOwn(PAGES, kind)) throw new Error(`There is no page '${kind}'. Available: #/run/..., #/compare/..., #/live/..., #/sweep/..., #/runs/...`);
    return PAGES[kind](rest, new URLSearchParams(query || ""));
  }

  function decoded(part) {
    try {
      return decodeURIComponent(part);
    } catch {
      throw new Error(`The address cannot be read at '${part}': a % must come before two hexadecimal digits.`);
    }
  }

  async function show() {
    const [path] = location.hash.split("?");
    if (current && current.restore && current.element.isConnected && path === shown) { current.restore(foundry.address.read()); return; }
    const mine = turn += 1, main = document.getElementById("main");
    shown = path;
    if (current && current.dispose) current.dispose();
    current = null;
    try {
      const page = await asked();
      if (mine !== turn) { if (page.dispose) page.dispose(); return; }
      current = page;
      fill(main, page.element);
      document.title = `${document.getElementById("crumbs").textContent.replace(/› /g, "").trim()} · foundry view`;
      foundry.page = page;
    } catch (error) {
      if (mine === turn) fill(main, h("h1", {}, "There is nothing to show"), h("p", {class: "warning", role: "alert"}, error.message));
    }
  }

  document.querySelector(".skip").addEventListener("click", (event) => {
    event.preventDefault(); // the address does not belong to a page
    document.getElementById("main").focus();
  });
  window.addEventListener("hashchange", (event) => {
    if (current && current.restore) lastOverview.set(current.sweep.id, new URL(event.oldURL).hash);
    show();
  });
  show();
})(window.Foundry);
