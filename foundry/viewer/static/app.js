"use strict";
/* Which page is shown follows from the address after #. */
(function (foundry) {
  const {h, fill, badge, quote} = foundry.dom;
  let current = null;
  let turn = 0;
  let remembering = null;

  /** Keep what is looked at in the address, so that it can be sent on; the history does not grow by it. */
  foundry.remember = ({step, agent}) => {
    const [path] = location.hash.split("?");
    const rest = `step=${step}${agent === null || agent === undefined ? "" : `&agent=${agent}`}`;
    clearTimeout(remembering);
    remembering = setTimeout(() => {
      if (location.hash.split("?")[0] === path) history.replaceState(null, "", `${path}?${rest}`);
    }, 250);
  };

  /** Say how a run stands, and whether there is news of it. */
  foundry.showState = (element, data) => fill(element, badge(data.progress.status),
    data.lost ? h("span", {class: "note"}, " no news from the server; what was loaded stays") : null,
    data.progress.error ? h("span", {class: "warning"}, `${data.progress.error_type || "Error"}: ${data.progress.error}`) : null);

  foundry.runHeading = (data, state) => {
    const {about} = data;
    return h("header", {class: "heading"}, h("h1", {}, about.model, h("small", {}, ` ${about.prompt} · ${about.world} · seed ${about.seed}`)), state,
      h("details", {class: "config"}, h("summary", {}, "configuration"), quote(JSON.stringify(about.config, null, 2), "small")));
  };

  function crumbs(parts) {
    fill(document.getElementById("crumbs"), parts.map(([text, address]) =>
      ["› ", address ? h("a", {href: address}, text) : h("span", {"aria-current": "page"}, text), " "]));
  }

  async function runPage([sweep, run], query) {
    const data = await new foundry.RunData(sweep, run).open();
    crumbs([[sweep, `#/sweep/${sweep}`], [run, null]]);
    const agent = query.get("agent");
    const page = data.form.page(data, {step: Number(query.get("step")) || null, agent: agent === null ? null : Number(agent)});
    data.follow(() => page.disposed);
    return page;
  }

  async function comparePage([sweep, ...runs], query) {
    const open = await Promise.all(runs.slice(0, 4).map((run) => new foundry.RunData(sweep, run).open()));
    crumbs([[sweep, `#/sweep/${sweep}`], [`${open.length} runs side by side`, null]]);
    const agent = query.get("agent");
    const page = new foundry.ComparePage(open, {step: Number(query.get("step")) || null, agent: agent === null ? null : Number(agent)});
    open.forEach((data) => data.follow(() => page.disposed));
    return page;
  }

  async function sweepPage([wanted]) {
    const {sweeps, unreadable} = await foundry.source.json("sweeps");
    const sweep = wanted ? sweeps.find((one) => one.id === wanted) : sweeps[0];
    if (!sweep) throw new Error(`There is no sweep '${wanted}'. There are: ${sweeps.map((one) => one.id).join(", ")}.`);
    crumbs([[sweep.name, null]]);
    return new foundry.Overview(sweeps, sweep, unreadable).open();
  }

  const PAGES = {run: runPage, compare: comparePage, sweep: sweepPage, "": sweepPage};

  /** Return the page that the address asks for. */
  async function asked() {
    const [path, query] = location.hash.replace(/^#\/?/, "").split("?");
    const [kind, ...rest] = path.split("/").map(decoded);
    if (!Object.hasOwn(PAGES, kind)) throw new Error(`There is no page '${kind}'. There are: #/run/..., #/compare/..., #/sweep/...`);
    return PAGES[kind](rest, new URLSearchParams(query || ""));
  }

  function decoded(part) {
    try {
      return decodeURIComponent(part);
    } catch {
      throw new Error(`The address cannot be read at '${part}': a % stands before two hexadecimal digits.`);
    }
  }

  async function show() {
    const mine = turn += 1, main = document.getElementById("main");
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
      if (mine === turn) fill(main, h("p", {class: "warning", role: "alert"}, error.message));
    }
  }

  document.querySelector(".skip").addEventListener("click", (event) => {
    event.preventDefault(); // its address is not one of a page
    document.getElementById("main").focus();
  });
  window.addEventListener("hashchange", show);
  show();
})(window.Foundry);
