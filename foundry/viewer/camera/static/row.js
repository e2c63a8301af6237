"use strict";
/* Shows the images that all compared models saw at one step, in one row. A click enlarges an image. */
(function (foundry) {
  const {h} = foundry.dom;

  class Row {
    /** @param panels of the compared runs; the colours of the runs are in the same order */
    constructor(panels, looks) {
      this.panels = panels;
      this.buttons = panels.map((panel, index) => this.button(panel, index));
      panels.forEach(({element, view}, index) => {
        view.frame.append(this.buttons[index]);
        element.style.borderTopColor = looks[index].paint;
      });
      this.element = h("section", {class: "picture-row", "aria-label": "What each model saw"},
        foundry.camera.marking(panels.map(({view}) => view)), h("div", {class: "pictures", tabindex: "0", role: "group", "aria-label": "Pictures"}, panels.map((panel) => panel.element)));
    }

    button({run}, index) {
      return h("button", {type: "button", class: "enlarge", "aria-label": `Large picture: ${run.name}`, "aria-pressed": "false", onclick: () => this.enlarge(index)});
    }

    /** Enlarge one picture and shrink the others. If the picture is already large, shrink it too. */
    enlarge(chosen) {
      this.panels.forEach(({element}, index) => {
        const large = element.classList.toggle("large", index === chosen && !element.classList.contains("large"));
        this.buttons[index].setAttribute("aria-pressed", String(large));
        if (large) element.scrollIntoView({block: "nearest", inline: "center"});
      });
    }
  }

  foundry.camera.Row = Row;
})(window.Foundry);
