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

    link(file, text) { return h("a", {href: foundry.source.file(this.sweep, file.path), target: "_blank", rel: "noopener"}, text); }

    draw(links) {
      const reports = links.filter((file) => file.kind === "html"), figures = grouped(links.filter((file) => FIGURES.includes(file.kind)), (file) => file.label);
      const tables = grouped(links.filter((file) => file.kind === "csv" || file.kind === "md"), (file) => file.label);
      fill(this.reports, reports.map((file) => [this.link(file, file.path), " "]));
      const files = (ofName) => ofName.map((file) => [" ", this.link(file, file.kind.toUpperCase())]);
      const list = ([name, ofName]) => h("li", {}, name.replaceAll("_", " "), files(ofName));
      fill(this.element, figures.size + tables.size ? h("details", {class: "gallery"}, h("summary", {}, `figures (${figures.size}) and tables (${tables.size})`),
        figures.size ? [h("h3", {}, "Figures"), h("ul", {}, [...figures].map(list))] : null, tables.size ? [h("h3", {}, "Tables"), h("ul", {}, [...tables].map(list))] : null) : null);
    }
  }

  foundry.Gallery = Gallery;
})(window.Foundry);
