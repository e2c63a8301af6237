"use strict";
/* Lists the files of the analysis: the report, a figure per measure, tables. */
(function (foundry) {
  const {h, fill, grouped} = foundry.dom;
  const FIGURES = ["svg", "png"];

  class Gallery {
    constructor(sweep) {
      this.sweep = sweep;
      this.reports = h("span", {class: "reports"});
      this.element = h("div");
    }

    link(one, text) { return h("a", {href: foundry.source.file(this.sweep, one.path), target: "_blank", rel: "noopener"}, text); }

    draw(links) {
      const reports = links.filter((one) => one.kind === "html"), figures = grouped(links.filter((one) => FIGURES.includes(one.kind)), (one) => one.label);
      const tables = grouped(links.filter((one) => one.kind === "csv" || one.kind === "md"), (one) => one.label);
      fill(this.reports, reports.map((one) => [this.link(one, one.path), " "]));
      const files = (ofName) => ofName.map((one) => [" ", this.link(one, one.kind.toUpperCase())]);
      const list = ([name, ofName]) => h("li", {}, name.replaceAll("_", " "), files(ofName));
      fill(this.element, figures.size + tables.size ? h("details", {class: "gallery"}, h("summary", {}, `figures (${figures.size}) and tables (${tables.size})`),
        figures.size ? [h("h3", {}, "Figures"), h("ul", {}, [...figures].map(list))] : null, tables.size ? [h("h3", {}, "Tables"), h("ul", {}, [...tables].map(list))] : null) : null);
    }
  }

  foundry.Gallery = Gallery;
})(window.Foundry);
