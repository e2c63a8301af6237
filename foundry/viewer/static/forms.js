"use strict";
/* Finds the page for runs of a form by name: `<form>/page.js` of this page, or a script of the user. */
(function (foundry) {
  const forms = {}, loading = new Map();

  /** Load a script from this page's own folder, once. */
  function script(address) {
    if (!loading.has(address)) {
      loading.set(address, new Promise((resolve, reject) => {
        const element = document.createElement("script");
        element.src = address;
        element.onload = resolve;
        element.onerror = () => { loading.delete(address); reject(new Error(`${address} is missing.`)); };
        document.head.appendChild(element);
      }));
    }
    return loading.get(address);
  }

  /**
   * Register the page for runs of a form; its script calls this once.
   * @param form.needs further scripts from this page's own folder, in the order of loading
   * @param form.page(data, {step, agent}) returns the page of a run: `element`, `clock`, `dispose()`
   * @param form.panel(data, {onPick}) returns the panel of a run on the page that compares runs: `element`,
   *   `draw(step, share)`, `select(agent)`, `label(name)`, and optionally `dispose()`; `draw` returns whether the records
   *   of the step are loaded
   * @param form.overlay(runs, {names, looks, onPick}) optional; returns a panel with all runs in one picture and with a
   *   `box`, or null
   * @param form.arranged(panels, looks) optional; returns an element that contains the panels of the compared runs
   * @param form.legend(about, together) optional; returns a legend of the marks in a panel and, if `together`, in `overlay`
   * @param form.chunk(frames, about) converts the frames of the server into the chunk that page and panel use; a chunk
   *   has `first` and `last`
   * @param form.same(chunk, about, step, agent) returns a text; two runs with equal texts did the same
   * @param form.decision(decision) returns elements that show an agent's decision at a step
   * @param form.gist(decision) returns a short version of a decision: {thoughts, did, said}
   * @param form.outcome(decision, kind, before) returns the outcome of a call, or undefined; `before` is the number of
   *   earlier calls of this kind in the step
   * @param form.decided(record, kind, about) optional; returns the decision on a kind of question (null: any) in a few words
   * @param form.player(about) returns the jumps, signs and fires of the player
   */
  foundry.form = (name, form) => { forms[name] = form; };
  foundry.forms = forms;
  foundry.script = script;

  /** Return the page for a run. Its scripts are loaded in order, because each may need those before it. */
  foundry.formOf = async (about) => {
    let form = null;
    for (const part of about.page) {
      await script(part.script);
      form = forms[part.form];
      if (!form) throw new Error(`${part.script} does not call Foundry.form("${part.form}", {...}). The browser's console may show the reason.`);
      for (const address of form.needs || []) await script(address);
    }
    return form;
  };
})(window.Foundry);
