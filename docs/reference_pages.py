"""Writes the reference of worlds, signatures, commands and settings from the code: `python docs/reference_pages.py`.

Each reference page holds a short table, which this module writes. The site shows the details too: `site_hooks.py` puts
them in the place of the line DETAILS while MkDocs builds the page. Worlds come from the docstrings of their classes and
their YAML files, signatures from their modules, commands from their help, settings from the comments of `conf/`.
"""

import importlib
import inspect
import math
import re
import sys
from typing import Any

import typer
import yaml
from typer.main import get_command

import foundry
from analysis.measure import Measure
from analysis.signature_modules import Part
from analysis.signatures import Signature, discover
from foundry import paths
from foundry.cli import app
from foundry.commands.application import EXTEND, LOOK, RUN, TRUST

ROOT = paths.PACKAGE.parent
CONF = ROOT / "conf"
BEGIN, END = "<!-- begin of the list -->\n", "<!-- end of the list -->\n"
DETAILS = "<!-- the site shows the details here -->\n"
SETTINGS = {
    "model.": ["model/ollama.yaml", "model/openai.yaml", "model/hf.yaml", "model/human.yaml", "model/replay.yaml"],
    "runner.": ["runner/local.yaml", "runner/dask.yaml"],
}
"""Files of settings by what stands before their keys on a command line."""
LONGEST = 60
"""Characters of a default that a table shows."""
SETTING = re.compile(r"( *)([a-z]\w*):(?: +([^#\s].*?))?(?: +# *(.*))?")
"""A line of YAML: indentation, key, value, comment."""


def with_list(page: str, listed: str) -> str:
    """Return a page with the list between its two marks made anew."""
    before, rest = page.split(BEGIN)
    return f"{before}{BEGIN}\n{listed}{END}{rest.split(END)[1]}"


def world_table() -> str:
    """Return a table of the shipped worlds with the first line of each file."""
    files = sorted((CONF / "world").glob("*.yaml"))
    rows = [f"| `{file.stem}` | {comments(file.read_text(encoding='utf-8'))[0]} |\n" for file in files]
    return "".join(["| world | purpose |\n|---|---|\n", *rows])


def world_details() -> str:
    """Return a section for each shipped world, and one for the policies that serve as baselines."""
    files = {file.stem: file.read_text(encoding="utf-8") for file in sorted((CONF / "world").glob("*.yaml"))}
    configs = {name: yaml.safe_load(text) for name, text in files.items()}
    policies = sorted({policy for config in configs.values() for policy in config.get("baselines", [])})
    worlds = [world_section(name, text, configs) for name, text in files.items()]
    rows = [f"- `{policy}`: {introduction_of_policy(policy)}" for policy in policies]
    return "".join(["## All worlds\n\n", *worlds]) + "\n".join(["### Scripted baselines\n", *rows, "\n"])


def comments(text: str) -> list[str]:
    """Return the lines of comment at the head of a YAML file."""
    return [line[2:] for line in text.splitlines() if line.startswith("# ") and "@package" not in line]


def world_section(name: str, text: str, configs: dict[str, Any]) -> str:
    """Return the section of a world: its comment, its rules, its settings and what goes with it."""
    parts = [*comments(text), "", *rules(name, configs), *settings_table(text), *surroundings(name, configs[name])]
    return "\n".join([f"### {name}\n", *parts, "\n"])


def rules(name: str, configs: dict[str, Any]) -> list[str]:
    """Return the docstring of a world's class, or the first world of the same class."""
    classes = {each: config.get("world", config).get("_target_") for each, config in configs.items()}
    if classes[name] is None:
        return []
    first = next(each for each, path in classes.items() if path == classes[name])
    if first != name:
        return [f"Its rules are those of [{first}](#{first}).", ""]
    title, *sections = re.split(r"(?m)^(\w+):\n", str(inspect.getdoc(named(classes[name]))))
    headings = zip(sections[::2], sections[1::2], strict=True)
    paragraphs = [f"- **{heading}**: {' '.join(body.split())}" for heading, body in headings]
    return [f"`{classes[name]}`: {' '.join(title.split())}", "", *paragraphs, ""]


def named(path: str) -> Any:
    """Return the class of a `_target_`."""
    module, name = path.rsplit(".", 1)
    return getattr(importlib.import_module(module), name)


def settings_table(text: str, prefix: str = "") -> list[str]:
    """Return a table with a row for each setting of a YAML file that has a plain value or a comment.

    A comment stands behind the setting, or on lines of its own before it.
    """
    rows, parents, before = [], dict[int, str](), list[str]()
    for line in text.splitlines():
        if comment_line := re.fullmatch(r" *# (.*)", line):
            before.append(comment_line[1])
            continue
        match, above, before = SETTING.fullmatch(line), " ".join(before), []
        if match is None or match[2] in {"defaults", "name", "baselines"}:
            continue
        indent, value, comment = len(match[1]), match[3] or "", match[4] or above
        parents = {depth: parent for depth, parent in parents.items() if depth < indent} | {indent: match[2]}
        if (value and value != "|-") or comment:
            default = f"`{value if len(value) <= LONGEST else value[:LONGEST] + ' ...'}` " if value else ""
            rows.append(f"| `{prefix}{'.'.join(parents.values())}` | {default}| {comment}{' ' if comment else ''}|")
    return ["| setting | default | meaning |", "|---|---|---|", *rows, ""] if rows else []


def setting_table() -> str:
    """Return a table of the settings that every run has."""
    return "\n".join(settings_table((CONF / "config.yaml").read_text(encoding="utf-8").split("\nhydra:")[0]))


def setting_details() -> str:
    """Return a table for each file of settings of models and runners."""
    names = [(prefix, name) for prefix, group in SETTINGS.items() for name in group]
    return "\n".join(line for prefix, name in names for line in setting_section(prefix, name))


def setting_section(prefix: str, name: str) -> list[str]:
    """Return the heading, the comment and the table of a file of settings."""
    text = (CONF / name).read_text(encoding="utf-8")
    introduction = text.split("_target_")[0]
    said = " ".join(comments(introduction))
    return [f"## {name.removesuffix('.yaml')}\n", said, "", *settings_table(text.removeprefix(introduction), prefix)]


def commands_of(group: str) -> dict[str, Any]:
    """Return the commands of a group of `foundry --help`."""
    every = get_command(app).commands  # type: ignore[attr-defined]
    return {name: command for name, command in every.items() if command.rich_help_panel == group}


def command_table() -> str:
    """Return a table for each group of commands."""
    tables = []
    for group in (RUN, LOOK, TRUST, EXTEND):
        rows = [f"| `foundry {name}` | {first_sentence(command)} |" for name, command in commands_of(group).items()]
        tables.append("\n".join([f"| {group.lower()} | purpose |", "|---|---|", *rows, ""]))
    return "\n".join(tables)


def first_sentence(command: Any) -> str:
    """Return the first paragraph of a command's help in one line."""
    return " ".join(str(command.help).partition("\n\n")[0].split())


def command_details() -> str:
    """Return a section for each command with its help and its options."""
    groups = [commands_of(group) for group in (RUN, LOOK, TRUST, EXTEND)]
    return "".join(command_section(name, command) for group in groups for name, command in group.items())


def command_section(name: str, command: Any) -> str:
    """Return the help and the options of a command."""
    context = typer.Context(command, info_name=f"foundry {name}")
    usage = f"    foundry {name} {' '.join(command.collect_usage_pieces(context))}"
    records = [param.get_help_record(context) for param in command.get_params(context)]
    rows = [f"| `{option}` | {escaped(meaning)} |" for option, meaning in filter(None, records) if option != "--help"]
    paragraphs = [escaped(paragraph) for paragraph in str(command.help).split("\n\n")]
    texts = "\n\n".join(paragraphs)
    return "\n".join(
        [f"### foundry {name}\n", usage, "", texts, "", "| option | meaning |", "|---|---|", *rows, "", ""]
    )


def escaped(text: str) -> str:
    """Return a text of a help with the signs that Markdown would read."""
    return re.sub(r"([<>*_|\[\]])", r"\\\1", text)


def name_details() -> str:
    """Return directives by which mkdocstrings renders the docstrings of public names and of records."""
    names = [(place, name) for place, group in sorted(foundry._PLACES.items()) for name in group]
    directives = [f"::: {place}.{name}\n" for place, name in names if place != "foundry.records"]
    return "\n".join(["## Public names\n", *directives, "## Records\n", "::: foundry.records\n"])


def surroundings(name: str, config: dict[str, Any]) -> list[str]:
    """Return a line each for the prompts, the baselines and the signature of a world."""
    chosen = [entry["override /prompt"] for entry in config.get("defaults", []) if "override /prompt" in entry]
    prompts = sorted(path.stem for prompt in chosen for path in (CONF / "prompt").glob(f"{prompt}*.yaml"))
    signature = [f"[{name}](signatures.md#{name})"] if name in {each.name for each in discover()} else []
    rows = {"Prompts": [f"`{each}`" for each in prompts], "Signature": signature,
            "Baselines": [f"`{policy}`" for policy in config.get("baselines", [])]}  # fmt: skip
    return [f"- **{heading}**: {', '.join(values)}" for heading, values in rows.items() if values]


def introduction_of_policy(name: str) -> str:
    """Return the first paragraph of the docstring of a scripted model's class."""
    config = yaml.safe_load((CONF / "model" / f"{name}.yaml").read_text(encoding="utf-8"))
    return " ".join(str(inspect.getdoc(named(config["_target_"]))).partition("\n\n")[0].split())


def signature_table() -> str:
    """Return a table of the signatures with the forms that they measure."""
    rows = [f"| `{each.name}` | {', '.join(form(part) for part in each.parts)} | {subject(each)} |\n"
            for each in every_signature()]  # fmt: skip
    return "".join(["| signature | forms | subject |\n|---|---|---|\n", *rows])


def subject(signature: Signature) -> str:
    """Return the first sentence about a signature."""
    return re.split(r"(?<=\.) ", introduction(signature.parts[-1]))[0]


def every_signature() -> list[Signature]:
    """Return the shipped signatures by name; those of labels stand in `people.md`."""
    return sorted((each for each in discover() if not each.is_label), key=lambda each: each.name)


def signature_details() -> str:
    """Return a section for each signature."""
    return "".join(signature_section(signature) for signature in every_signature())


def signature_section(signature: Signature) -> str:
    """Return the section of a signature: what its modules say of themselves, and a line a measure."""
    modules = [f"*{form(part)}*, `{part.module}`: {introduction(part)}" for part in signature.parts]
    measures = [line(signature, name, measure) for name, measure in signature.measures.items()]
    return "\n".join([f"### {signature.name}\n", "\n\n".join(modules), "", *measures, "\n"])


def form(part: Part) -> str:
    """Return the form of the worlds that a module measures."""
    return part.module.split(".")[1]


def introduction(part: Part) -> str:
    """Return the docstring of a module in one line, without the signature's name before it."""
    text = " ".join(str(inspect.getdoc(sys.modules[part.module])).split())
    title, colon, rest = text.partition(": ")
    return rest if colon and len(title.split()) < 4 else text


def line(signature: Signature, name: str, measure: Measure) -> str:
    """Return what a measure is called, its range, its null, and its forms where not all have it."""
    forms = [form(part) for part in signature.parts if name in part.measures]
    named = f"**`{name}`**" if name in signature.headline else f"`{name}`"
    only = f" ({', '.join(forms)})" if len(forms) < len(signature.parts) else ""
    null = f"; null {measure.null}" if measure.null else ""
    return f"- {named}{only}: {measure.label}, {extent(measure)}{null}"


def extent(measure: Measure) -> str:
    """Return the range of a measure in words."""
    if math.isinf(measure.high):
        return "any" if math.isinf(measure.low) else f"{measure.low:g} up"
    return f"{measure.low:g}..{measure.high:g}"


DOCS = ROOT / "docs"
TABLES = {
    DOCS / "worlds.md": world_table,
    DOCS / "signatures.md": signature_table,
    DOCS / "commands.md": command_table,
    DOCS / "settings.md": setting_table,
}
SITE = {
    "worlds.md": world_details,
    "signatures.md": signature_details,
    "commands.md": command_details,
    "settings.md": setting_details,
    "python.md": name_details,
}

if __name__ == "__main__":
    for path, table in TABLES.items():
        path.write_text(with_list(path.read_text(encoding="utf-8"), table()), encoding="utf-8")
