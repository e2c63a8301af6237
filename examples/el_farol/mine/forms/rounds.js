"use strict";
/* How many went to the bar, above what the page shows of any run of rounds. */
(function (foundry) {
  const {any} = foundry.forms, {h, fill} = foundry.dom;

  class BarPage extends any.Page {
    stage() {
      this.bar = h("p", {class: "attendance"});
      return [this.bar, ...super.stage()];
    }

    async drawStep(step) {
      const rows = (await this.data.load(step)).ofStep.get(step) || [];
      const went = rows.filter((row) => row.action === "go").length;
      if (step === this.clock.step) fill(this.bar, `Evening ${step}: `, h("meter", {min: 0, max: rows.length, value: went}), ` ${went} of ${rows.length} went`);
    }
  }

  foundry.form("rounds", {...any, page: (data, wanted) => new BarPage(data, wanted)});
})(window.Foundry);
