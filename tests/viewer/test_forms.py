"""What shows a form is found by its name: in the package, in the user's own folder, else what all forms share."""

from pathlib import Path
from typing import Any

import msgspec
import pytest

import made_up_rounds as rounds
import viewer_pages
from browser import browser_page
from commands import foundry
from foundry.errors import InputError
from foundry.own_code import VARIABLE
from foundry.storing.store import SweepFolder
from foundry.viewer.any.any_view import AnyView
from foundry.viewer.camera.camera_view import CameraView
from foundry.viewer.export import export
from foundry.viewer.forms import scripts_of, view_of
from foundry.viewer.grid.grid_view import GridView
from foundry.viewer.resources import Resources
from foundry.viewer.server import serving

SERVER_PART = """
from pathlib import Path

from foundry.viewer.any.any_view import AnyView
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
    (folder / "mine" / "forms").mkdir(parents=True)
    (folder / "mine" / "forms" / "circle.py").write_text(server_part, encoding="utf-8")
    (folder / "mine" / "forms" / "circle.js").write_text(page_part, encoding="utf-8")
    return folder / "mine"


@pytest.mark.parametrize(
    ("form", "view", "script"),
    [
        ("grid", GridView, "grid/page.js"),
        ("camera", CameraView, "camera/page.js"),
        ("any", AnyView, "any/page.js"),
        ("rounds", AnyView, "any/page.js"),
        ("nobodys", AnyView, "any/page.js"),
        ("server", AnyView, "any/page.js"),
        ("static", AnyView, "any/page.js"),
    ],
)
def test_a_form_is_shown_by_what_has_its_name_else_by_what_all_share(form: str, view: type, script: str):
    assert view_of(form).run is view
    assert [script.address for script in scripts_of(form)] == [script]


def test_a_form_of_ones_own_adds_only_what_no_shipped_form_of_its_name_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    (tmp_path / "mine" / "forms").mkdir(parents=True)
    (tmp_path / "mine" / "forms" / "grid.py").write_text("VIEWER = PAGE = ANALYSIS = 7")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "mine"))
    for lookup, part in ((view_of, "VIEWER"), (scripts_of, "PAGE")):
        with pytest.raises(InputError, match=rf"{part} in mine/forms/grid.py has the name 'grid'.*to 'grid_2'"):
            lookup("grid")


def circle_sweep(folder: Path) -> SweepFolder:
    made = rounds.sweep(folder / "circle", models=("first",), scenario=Circle(name="bar", agents=5, steps=12))
    rounds.whole_run(made.runs()[0])
    return made


@pytest.fixture
def circle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SweepFolder:
    monkeypatch.setenv(VARIABLE, str(write_circle(tmp_path)))
    return circle_sweep(tmp_path)


def test_a_form_of_ones_own_reads_its_records_its_own_way(circle: SweepFolder):
    resources, address = Resources(circle.path), f"run/circle/{circle.runs()[0].id}"
    about = msgspec.json.decode(resources.get(f"{address}/about").content)
    assert (about["form"], about["around"]) == ("circle", 5)
    assert [one["script"] for one in about["page"]] == ["any/page.js", "forms/circle/page.js"]
    assert msgspec.json.decode(resources.get(f"{address}/neighbours/0").content) == {"neighbours": [4, 1]}
    resources.close()


@pytest.mark.parametrize(
    ("server_part", "said"),
    [
        ("import nothing_of_this_name", "mine/forms/circle.py cannot be imported: ModuleNotFoundError"),
        ("VIEWER = 7", "mine/forms/circle.py: VIEWER must be of type FormView; got 7"),
        (SERVER_PART.replace("circle.js", "other.js"), r"its PAGE '.*other.js' does not exist"),
    ],
)
def test_a_bad_file_of_a_form_is_named_and_hurts_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, server_part: str, said: str
):
    monkeypatch.setenv(VARIABLE, str(write_circle(tmp_path, server_part)))
    made, other = circle_sweep(tmp_path), rounds.sweep(tmp_path / "bar", models=("first",))
    resources = Resources(tmp_path)
    with pytest.raises(InputError, match=said):
        resources.get(f"run/circle/{made.runs()[0].id}/about")
    assert resources.get(f"run/bar/{other.runs()[0].id}/about").content
    assert b'"form":"circle"' in resources.get("sweep/circle/rows/0").content, "the sweep is listed all the same"
    resources.close()


def test_the_command_exports_a_form_of_ones_own(tmp_path: Path):
    mine, made = write_circle(tmp_path), circle_sweep(tmp_path)
    trusting = ("--config-dir", str(mine), "--trust-targets", "made_up_rounds")
    done = foundry("view", str(made.path), "--export", "page", *trusting, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    shown = tmp_path / "page" / "forms" / "circle" / "page.js"
    assert shown.read_bytes() == (mine / "forms" / "circle.js").read_bytes()
    assert len(list((tmp_path / "page" / "data").rglob("picture/*.js"))) == 13
    assert len(list((tmp_path / "page" / "data").rglob("neighbours/*.js"))) == 5


NEIGHBOURS = "() => document.querySelector('.circle')?.dataset.neighbours === '4,1'"


@pytest.mark.browser
def test_a_form_of_ones_own_is_shown_on_top_of_what_all_share_from_a_server_and_from_files(
    page: Any, circle: SweepFolder, tmp_path: Path
):
    trusted = ("made_up_rounds",)
    exported = export(circle.path, tmp_path / "page", trusted=trusted)
    with serving(circle.path, trusted=trusted) as server:
        for address in (server.url, exported.page.as_uri()):
            viewer_pages.go(page, address, f"run/circle/{circle.runs()[0].id}?step=3&agent=0")
            page.wait_for_selector("text=A circle of 5 at step 3")
            page.wait_for_function(NEIGHBOURS)
            page.wait_for_selector("[data-agent='4']", state="attached")
            page.wait_for_function("() => document.querySelector('.picture img').naturalWidth === 300")
            page.keyboard.press("ArrowRight")
            page.wait_for_selector("text=A circle of 5 at step 4")
        page.goto("about:blank")


@pytest.mark.browser
def test_a_page_part_that_registers_nothing_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(VARIABLE, str(write_circle(tmp_path, page_part="this is no script")))
    made = circle_sweep(tmp_path)
    with serving(made.path) as server, browser_page(allowed_errors=("Unexpected identifier",)) as page:
        page.goto(f"{server.url}#/run/circle/{made.runs()[0].id}")
        page.wait_for_selector("[role=alert]")
        assert 'forms/circle/page.js does not call Foundry.form("circle"' in page.text_content("[role=alert]")
