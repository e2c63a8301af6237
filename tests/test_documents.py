"""Documents, and the files for containers and for citations, agree with the folders and the code."""

import importlib.util
import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from typer.main import get_command

from commands import succeeds
from foundry import __version__, paths
from foundry.cli import app, run
from foundry.composing.compose import compose
from foundry.labels.definition import read_label
from reference_pages import DETAILS, SITE, TABLES, with_list

ROOT = paths.PACKAGE.parent
READMES = [ROOT / "tests" / "README.md", ROOT / "foundry" / "viewer" / "README.md"]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "benchmarks").glob("*.md"), *READMES])
FOLDERS = "foundry|analysis|conf|sweeps|assets|benchmarks|hydra_plugins|tests|docs|examples"
NAMED = re.compile(rf"`((?:{FOLDERS})/[\w./-]*)`")
PATTERN = re.compile(rf"`((?:{FOLDERS})/[\w./<>*-]*[<*][\w./<>*-]*)`")
WRITTEN = re.compile(r"analysis/[\w-]+\.(?:csv|json|sqlite|parquet|tex|md)|analysis/(?:plots|replay)/?")
"""Files that the analysis writes into a sweep's folder."""
COMMAND = re.compile(r"(?m)^    foundry (.+?)(?:  +[a-z].*)?$")
"""A command on a line of its own, without what is said of it behind two spaces."""
VARIABLE = re.compile(r'(?m)^    (\w+)="(.*)"$')
"""A variable of the shell that later commands share."""
NEW = re.compile(r"foundry new (\w+) (\w+)")
FILE = re.compile(r"(?ms)^```yaml\n# mine/((?:world|prompt|model|labels)/\w+\.yaml)\n(.*?)^```")
"""A file for `--config-dir mine`."""
SCENES = {"kibo_real": ("scene=kibo.usdz",)}
"""Of the worlds of the documents whose scenes are not shipped: others that are."""


@pytest.mark.parametrize(
    "document", [path for path in DOCUMENTS if path.name != "CHANGELOG.md"], ids=lambda one: one.name
)
def test_every_file_that_a_document_names_is_there(document: Path):
    text = document.read_text(encoding="utf-8")
    named = {name for name in NAMED.findall(text) if not WRITTEN.fullmatch(name)}
    assert {name for name in named if not (ROOT / name).exists()} == set()
    patterns = {re.sub(r"<\w+>", "*", one) for one in PATTERN.findall(text) if not WRITTEN.match(one)}
    assert {pattern for pattern in patterns if not any(ROOT.glob(pattern.rstrip("/")))} == set()


def test_the_architecture_names_every_folder_and_every_file_at_the_top():
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    package = ROOT / "foundry"
    paths_below = (*package.iterdir(), *(package / "worlds").iterdir())
    folders = [f"{path.relative_to(ROOT).as_posix()}/" for path in paths_below if any(path.glob("*.py"))]
    files = [file.name for file in package.glob("*.py") if not file.name.startswith("__")]
    missing = [name for name in (*folders, *files) if name not in text]
    assert missing == []


def commands_of(document: Path) -> list[list[str]]:
    text = re.sub(r" \\\n +", " ", document.read_text(encoding="utf-8"))
    for name, value in VARIABLE.findall(text):
        text = text.replace(f"${name} ", f"{value} ").replace(f"${name}\n", f"{value}\n")
    commands = (shlex.split(line, comments=True) for line in COMMAND.findall(text))
    return [[part for part in command if part != "..."] for command in commands]


def files_of(document: Path) -> dict[str, str]:
    return dict(FILE.findall(document.read_text(encoding="utf-8")))


@pytest.mark.slow
@pytest.mark.parametrize("document", [path for path in DOCUMENTS if commands_of(path)], ids=lambda one: one.name)
def test_every_command_of_a_document_is_one_that_foundry_takes(document: Path, workspace: Path):
    (workspace / "mine").mkdir()
    (workspace / "examples").symlink_to(ROOT / "examples")
    subcommands = get_command(app).commands  # type: ignore[attr-defined]
    for name, *rest in commands_of(document):
        if any(part.startswith("hydra/launcher=") for part in rest):
            continue  # of a package that is not installed
        if name not in subcommands:
            compose([name, *rest])
            continue
        command = subcommands[name]
        while rest and rest[0] in getattr(command, "commands", {}):
            command = command.commands[rest.pop(0)]
        command.make_context(name, rest)


@pytest.mark.slow
def test_the_first_comparison_runs_as_it_stands(workspace: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("FOUNDRY_WORKERS", "1")
    commands = commands_of(ROOT / "docs" / "first_comparison.md")
    alone = [command for command in commands if command[0] not in ("view", "doctor", "plan")]  # those write nothing
    assert len(alone) == 6
    assert [command for command in alone if run(command) != 0] == []
    assert "hazard.away_beyond_blind" in (workspace / "outputs/study/preregistration.yaml").read_text(encoding="utf-8")
    summary = (workspace / "outputs/study/analysis/summary.md").read_text(encoding="utf-8")
    assert "exploratory" not in summary.splitlines()[0]


def test_every_part_that_a_document_begins_can_be_begun(workspace: Path):
    help_of_new = get_command(app).commands["new"].help  # type: ignore[attr-defined]
    texts = [help_of_new, *(path.read_text(encoding="utf-8") for path in DOCUMENTS if path.name != "CHANGELOG.md")]
    begun = sorted({part for text in texts for part in NEW.findall(text)})
    assert begun and [part for part in begun if run(["new", *part]) != 0] == []


@pytest.mark.slow
@pytest.mark.parametrize("document", [path for path in DOCUMENTS if files_of(path)], ids=lambda one: one.name)
def test_the_files_of_a_document_run_as_they_stand(document: Path, workspace: Path):
    for name, text in files_of(document).items():
        file = workspace / "mine" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    for file in (workspace / "mine").glob("world/*.yaml"):
        small = (*SCENES.get(file.stem, ()), "world.steps=2", "analyze=false", "runner.workers=1")
        succeeds("--config-dir", "mine", f"world={file.stem}", "model=scripted/random", *small, cwd=workspace)
    for file in (workspace / "mine").glob("model/*.yaml"):
        assert compose(["--config-dir", str(workspace / "mine"), f"model={file.stem}"]) is not None
    for file in (workspace / "mine").glob("labels/*.yaml"):
        assert read_label(file).question


@pytest.mark.parametrize(("path", "table"), TABLES.items(), ids=lambda value: getattr(value, "name", ""))
def test_the_table_of_a_reference_page_is_what_the_code_says(path: Path, table: Callable[[], str]):
    page = path.read_text(encoding="utf-8")
    assert page == with_list(page, table()), "run `python docs/reference_pages.py`"


@pytest.mark.parametrize(("name", "details"), SITE.items(), ids=lambda value: getattr(value, "__name__", value))
def test_the_site_shows_details_of_every_row_of_a_reference_page(name: str, details: Callable[[], str]):
    page = (ROOT / "docs" / name).read_text(encoding="utf-8")
    assert page.count(DETAILS) == 1
    table = page.split("<!-- begin")[-1].split("<!-- end")[0] if name not in ("settings.md", "python.md") else ""
    rows = re.findall(r"^\| `([\w ]+)` \|", table, re.M)
    headings = re.findall(r"^### (.+)", details(), re.M)
    assert [row for row in rows if row not in headings] == []


def test_every_yaml_block_of_a_document_is_a_file_that_a_test_runs():
    blocks = {path.name: path.read_text(encoding="utf-8").count("```yaml\n") for path in DOCUMENTS}
    assert {name: count for name, count in blocks.items() if count} == {
        path.name: len(FILE.findall(path.read_text(encoding="utf-8"))) for path in DOCUMENTS if blocks[path.name]
    }


def test_a_page_of_the_site_is_in_its_navigation_and_is_at_most_one_kind():
    nav = yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))["nav"]
    pages = [
        page
        for entry in nav
        for kind in entry.values()
        if isinstance(kind, list)
        for one in kind
        for page in one.values()
    ]
    written = {path.name for path in (ROOT / "docs").glob("*.md")}
    assert set(pages) == written | {"architecture.md"} and len(pages) == len(set(pages)) < 20


def test_the_citation_names_this_version():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (citation["version"], citation["license"], citation["type"]) == (__version__, "Apache-2.0", "software")


def test_the_image_has_what_draws_scenes_and_extras_that_exist():
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    spec = importlib.util.spec_from_file_location("tasks", ROOT / "tasks.py")
    assert spec.loader is not None
    tasks = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tasks)
    assert set(tasks.GL_PACKAGES) <= set(shlex.split(text, comments=True))
    (extras,) = re.findall(r'"/src\[([\w,]+)\]"', text)
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert all(re.search(rf"^{extra} = \[", project, re.MULTILINE) for extra in extras.split(","))
