"""What `import foundry` offers: typed names, imported when they are asked for, in a notebook too."""

import ast
import asyncio
import re
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import foundry
from foundry import paths
from foundry.calling import off_the_loop

SMALL = ("world.agents=3", "world.steps=2", "runner.workers=1")
DOCS = (paths.PACKAGE.parent / "docs" / "python.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", foundry.__all__)
def test_every_public_name_is_there_and_documented(name: str):
    found = getattr(foundry, name)
    assert (not isinstance(found, type) or found.__doc__) and name in dir(foundry)
    assert re.search(rf"`{name}[`(]", DOCS), "docs/python.md names it"


def test_type_checkers_see_the_names_where_they_are():
    tree = ast.parse(Path(str(foundry.__file__)).read_text(encoding="utf-8"))
    typed = {
        alias.name: node.module
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        and node.module not in ("__future__", "typing", "foundry.own_code", "foundry.version")
        for alias in node.names
    }
    places = {name: place for place, names in foundry._PLACES.items() for name in names}
    assert typed == places and set(places) == set(foundry.__all__)
    assert (paths.PACKAGE / "py.typed").is_file() and (paths.PACKAGE.parent / "analysis" / "py.typed").is_file()


def test_importing_it_imports_its_version_alone():
    code = "import sys, foundry; print([n for n in sys.modules if n.startswith(('foundry.', 'analysis', 'hydra'))])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['foundry.version']"


def test_a_sweep_is_run_and_gone_on_with(workspace: Path):
    asked = ("model=scripted/random,scripted/stay", "output.dir=out", *SMALL)
    first = foundry.sweep(*asked)
    assert (first.path, first.complete, first.failed) == (Path("out"), 2, ())
    written = {file: file.stat().st_mtime_ns for file in Path("out").rglob("run.json")}
    assert foundry.sweep(*asked).complete == 2
    assert {file: file.stat().st_mtime_ns for file in Path("out").rglob("run.json")} == written
    assert sorted(set(foundry.load(first.path).runs["model"])) == ["scripted/random", "scripted/stay"]


def test_one_run_is_played_in_a_running_event_loop(workspace: Path, capsys: pytest.CaptureFixture[str]):
    async def notebook() -> foundry.Ran:
        return foundry.run("model=scripted/random", "seed=4", "output.dir=out", *SMALL)

    ran = asyncio.run(notebook())
    assert ran.complete == 1 and list(foundry.load(ran.path).runs["seed"]) == [4]
    assert capsys.readouterr().out == ""


def test_a_run_that_fails_is_told_with_its_cause(workspace: Path):
    ran = foundry.run(
        "model=scripted/stay", "model._target_=policies.Faulty", "+world.personas.fate={doomed: 1}", "output.dir=out",
        *SMALL,
    )  # fmt: skip
    assert ran.complete == 0 and len(ran.failed) == 1 and "a bug" in ran.failed[0]


@pytest.mark.parametrize("wrong", [("model=scripted/randm",), ("-m", "seed=0-1"), ("seed=0-1", "model=scripted/stay")])
def test_what_is_wrong_is_one_line(wrong: tuple[str, ...], workspace: Path):
    with pytest.raises(foundry.InputError) as raised:
        foundry.run(*wrong)
    assert "\n" not in str(raised.value) and list(workspace.iterdir()) == []


def test_a_foreign_package_in_the_way_is_told_in_one_line(tmp_path: Path):
    (tmp_path / "analysis").mkdir()
    (tmp_path / "analysis" / "__init__.py").write_text("mine = True\n")
    code = "import foundry\ntry:\n    foundry.load('x')\nexcept foundry.InputError as error:\n    print(error)"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert (
        done.stdout.startswith("another package named 'analysis' hides foundry's own") and done.stdout.count("\n") == 1
    )
    assert str(tmp_path / "analysis") in done.stdout


def test_an_interrupt_stops_the_work_in_its_thread():
    asked, ended = threading.Event(), threading.Event()

    def work() -> None:
        signal.pthread_kill(int(threading.main_thread().ident or 0), signal.SIGINT)
        if asked.wait(600):
            ended.set()

    async def notebook() -> None:
        off_the_loop(work, asked.set)

    loop = asyncio.new_event_loop()
    try:
        with pytest.raises(KeyboardInterrupt):
            loop.run_until_complete(notebook())
    finally:
        loop.close()
    ended.wait()
