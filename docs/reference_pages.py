"""Writes the lists in docs/signatures.md and docs/worlds.md: `python docs/reference_pages.py`.

The list of signatures comes from their modules. The list of worlds comes from the docstrings of their classes, from
their YAML files with the comments there, and from the docstrings of their scripted baselines.
"""

from __future__ import annotations

import importlib
import inspect
import math
import re
import sys
from typing import Any

import yaml

from analysis.measure import Measure
from analysis.signature_modules import Part
from analysis.signatures import Signature, discover
from foundry import paths

ROOT = paths.PACKAGE.parent
CONF = ROOT / "conf"
BEGIN, END = "<!-- begin of the list -->\n", "<!-- end of the list -->\n"
LONGEST = 60
"""Characters of a default that a table shows."""
SETTING = re.compile(r"( *)([a-z]\w*):(?: +([^#\s].*?))?(?: +# *(.*))?")
"""A line of YAML: indentation, key, value, comment."""


def with_list(page: str, listed: str) -> str:
    """Return a page with the list between its two marks made anew."""
    before, rest = page.split(BEGIN)
    return f"{before}{BEGIN}\n{listed}{END}{rest.split(END)[1]}"


def world_list() -> str:
    """Return a section for each shipped world, and one for the policies that serve as baselines."""
    files = {file.stem: file.read_text(encoding="utf-8") for file in sorted((CONF / "world").glob("*.yaml"))}
    configs = {name: yaml.safe_load(text) for name, text in files.items()}
    policies = sorted({policy for config in configs.values() for policy in config.get("baselines", [])})
    worlds = [world_section(name, text, configs) for name, text in files.items()]
    rows = [f"- `{policy}`: {introduction_of_policy(policy)}" for policy in policies]
    return "".join(worlds) + "\n".join(["## Scripted baselines\n", *rows, "\n"])


def world_section(name: str, text: str, configs: dict[str, Any]) -> str:
    """Return the section of a world: its comment, its rules, its settings and what goes with it."""
    comment = [line[2:] for line in text.splitlines() if line.startswith("# ") and "@package" not in line]
    parts = [*comment, "", *rules(name, configs), *settings_table(text), *surroundings(name, configs[name])]
    return "\n".join([f"## {name}\n", *parts, "\n"])


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


def settings_table(text: str) -> list[str]:
    """Return a table with a row for each setting of a YAML file that has a plain value or a comment."""
    rows, parents = [], dict[int, str]()
    for line in text.splitlines():
        match = SETTING.fullmatch(line)
        if match is None or match[2] in {"defaults", "name", "baselines"}:
            continue
        indent, value, comment = len(match[1]), match[3] or "", match[4] or ""
        parents = {depth: parent for depth, parent in parents.items() if depth < indent} | {indent: match[2]}
        if (value and value != "|-") or comment:
            default = f"`{value if len(value) <= LONGEST else value[:LONGEST] + ' ...'}` " if value else ""
            rows.append(f"| `{'.'.join(parents.values())}` | {default}| {comment}{' ' if comment else ''}|")
    return ["| setting | default | meaning |", "|---|---|---|", *rows, ""] if rows else []


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


def signature_list() -> str:
    """Return a section for each signature."""
    return "".join(signature_section(signature) for signature in sorted(discover(), key=lambda each: each.name))


def signature_section(signature: Signature) -> str:
    """Return the section of a signature: what its modules say of themselves, and a line a measure."""
    modules = [f"*{form(part)}*, `{part.module}`: {introduction(part)}" for part in signature.parts]
    measures = [line(signature, name, measure) for name, measure in signature.measures.items()]
    return "\n".join([f"## {signature.name}\n", "\n\n".join(modules), "", *measures, "\n"])


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


PAGES = {ROOT / "docs" / "signatures.md": signature_list, ROOT / "docs" / "worlds.md": world_list}

if __name__ == "__main__":
    for path, listed in PAGES.items():
        path.write_text(with_list(path.read_text(encoding="utf-8"), listed()), encoding="utf-8")
