"use strict";
/* The page of the form part_name: a line above what the page of any form shows. */
(function (foundry) {
  const {any} = foundry.forms, {h} = foundry.dom;

  class PartNamePage extends any.Page {
    stage() { return [this.line = h("p"), ...super.stage()]; }
    drawStep(step) { this.line.textContent = `${this.data.about.agents} agents in a ring, step ${step}`; }
  }

  foundry.form("part_name", {...any, page: (data, wanted) => new PartNamePage(data, wanted)});
})(window.Foundry);
