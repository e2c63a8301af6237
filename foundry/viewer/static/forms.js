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
   * @param form.panel(data, {onPick}) returns what is seen of a run beside others: `element`, `draw(step, share)`, which
   *   returns whether the records of the step are there, `select(agent)`, `label(name)`, and perhaps `dispose()`
   * @param form.overlay(runs, {names, looks, onPick}) returns all runs in one picture, a panel with a `box`, or null; it may be left out
   * @param form.arranged(panels, looks) returns an element that holds the panels of compared runs, right below the clock; it may be left out
   * @param form.legend(about, together) returns what the marks of a panel mean, and those of `overlay` where there is one;
   *   it may be left out
   * @param form.chunk(frames, about) makes of the frames that the server gives what page and panel want, `first` and `last` among it
   * @param form.same(chunk, about, step, agent) returns a text that is equal where two runs did the same
   * @param form.decision(decision) returns elements that tell what an agent did at a step
   * @param form.gist(decision) returns a short version of a decision: {thoughts, did, said}
   * @param form.outcome(decision, kind, before) returns the outcome of its call of a kind, `before` which that kind was put so often
   *   in the step, or undefined
   * @param form.decided(record, kind, about) returns in a few words what an agent decided on a kind of question, null for any; it may be left out
   * @param form.player(about) the jumps, signs and fires of its player
   */
  foundry.form = (name, form) => { forms[name] = form; };
  foundry.forms = forms;
  foundry.script = script;

  /** Return the page for a run. Its scripts are loaded in order, because each may need those before it. */
  foundry.formOf = async (about) => {
    let found = null;
    for (const part of about.page) {
      await script(part.script);
      found = forms[part.form];
      if (!found) throw new Error(`${part.script} does not say Foundry.form("${part.form}", {...}); the console of the browser may show the reason.`);
      for (const address of found.needs || []) await script(address);
    }
    return found;
  };
})(window.Foundry);
