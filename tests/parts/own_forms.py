"""A form of somebody's own, in a folder beside the clone: what reads its records, and what shows them."""

from __future__ import annotations

from pathlib import Path

import made_up_rounds as rounds

SERVER_PART = """
from pathlib import Path

from foundry.viewer.any.view import AnyView
from foundry.viewer.forms import FormView


class CircleView(AnyView):
    def about_world(self):
        return super().about_world() | {"around": self.agents}

    def neighbours(self, agent):
        return {"neighbours": [(agent - 1) % self.agents, (agent + 1) % self.agents]}

    parts = {**AnyView.parts, ("neighbours", 1): neighbours}


VIEWER = FormView(CircleView)
PAGE = Path(__file__).with_name("circle.js")
"""
PAGE_PART = """"use strict";
(function (foundry) {
  const {any} = foundry.forms, {h, fill} = foundry.dom;

  class CirclePage extends any.Page {
    stage() {
      this.circle = h("p", {class: "circle"});
      return [this.circle, ...super.stage()];
    }

    drawStep(step) { fill(this.circle, `A circle of ${this.data.about.around} at step ${step}`); }

    async chosen() {
      if (this.agent === null) return;
      const {neighbours} = await foundry.source.json(`${this.data.address}/neighbours/${this.agent}`);
      this.circle.dataset.neighbours = neighbours.join();
    }
  }

  foundry.form("circle", {...any, page: (data, wanted) => new CirclePage(data, wanted)});
})(window.Foundry);
"""


class Circle(rounds.Bar):
    """A world whose records are those of the bar, and of another form."""

    form = "circle"


def write_circle(folder: Path, server_part: str = SERVER_PART, page_part: str = PAGE_PART) -> Path:
    """Write `mine/forms/circle.py` and its page; returns the folder."""
    (folder / "mine" / "forms").mkdir(parents=True)
    (folder / "mine" / "forms" / "circle.py").write_text(server_part, encoding="utf-8")
    (folder / "mine" / "forms" / "circle.js").write_text(page_part, encoding="utf-8")
    return folder / "mine"
