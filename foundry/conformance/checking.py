"""From what was asked for to what was found: `foundry check world=mine`, or `foundry.check("world=mine")`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from foundry import own_code
from foundry.calling import off_the_loop
from foundry.composing.compose import compose
from foundry.composing.preflight import prompt_of, scenario_of
from foundry.conformance import edits, models, prompts, records, replies, signatures, worlds
from foundry.conformance.finding import Check, Finding, examine
from foundry.conformance.playing import WorldCase, policy_for
from foundry.errors import InputError
from foundry.expansion import settings_key
from foundry.running.build import build
from foundry.worlds.probe.editing import Edit, check_own_edits, find_edit, parts_of

WORLD_CHECKS = (*worlds.CHECKS, *records.CHECKS, *replies.CHECKS)
PARTS = ("world", "prompt", "model")
EDIT = "edit="
"""How edits are named, which are no part of a configuration."""


def check(*asked: str, config_dir: Path | str | None = None) -> tuple[Finding, ...]:
    """Check parts of one's own: `foundry.check("world=mine", config_dir="mine")`.

    Args:
        asked: overrides such as `world=mine`, `model=mine`, `prompt=mine`, of which those parts are checked,
            `edit=mine`, and signatures by their names or files.
        config_dir: a folder of one's own worlds, prompts and models, and of the code that they name.

    Returns:
        What each check found; `status` is `failed` where something is to be done.

    Raises:
        InputError: a part does not exist or cannot be built.
    """
    folder = [] if config_dir is None else ["--config-dir", str(config_dir)]
    return off_the_loop(lambda: tuple(check_asked([*asked, *folder])))


def check_asked(arguments: Sequence[str]) -> list[Finding]:
    """Return what the checks of all that a command line names find.

    Raises:
        InputError: it names nothing, or something that does not exist.
    """
    edited = [name for one in arguments if one.startswith(EDIT) for name in one.removeprefix(EDIT).split(",")]
    overrides, names = _shared_out([one for one in arguments if not one.startswith(EDIT)])
    chosen = [part for part in PARTS if any(one.lstrip("+").startswith(f"{part}=") for one in overrides)]
    if not chosen and not names and not edited:
        raise InputError("Nothing to check: name it, as in foundry check world=mine, or a signature by name or file.")
    composed = compose(["-m", *overrides])
    found: dict[str, list[Finding]] = {}
    for condition in composed.conditions if composed else ():
        for key, findings in _checked(condition.config, condition.seeds[0], chosen, names, edited):
            found.setdefault(key, findings())
    return [finding for findings in found.values() for finding in findings]


def _shared_out(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the overrides, with flags, and the names of signatures."""
    overrides: list[str] = []
    names: list[str] = []
    is_folder = False
    for argument in arguments:
        is_name = not is_folder and "=" not in argument and not argument.startswith(("-", "~"))
        (names if is_name else overrides).append(argument)
        is_folder = argument in own_code.CONFIG_DIR
    return overrides, names


def _checked(
    config: Mapping[str, Any], seed: int, chosen: Sequence[str], names: Sequence[str], edited: Sequence[str]
) -> Iterator[tuple[str, Callable[[], list[Finding]]]]:
    """Yield a key for each thing to check, and what finds out."""
    case = world_case(config, seed)
    cases: dict[str, tuple[Sequence[Check[Any]], Any]] = {
        "world": (WORLD_CHECKS, case),
        "prompt": (
            prompts.CHECKS,
            prompts.PromptCase(lambda: prompt_of(config), config["prompt"].get("templates", {}), case),
        ),
        "model": (models.CHECKS, models.ModelCase(build, config["model"], case)),
    }
    for part in chosen:
        title = f"{part} {config[part]['name']}"
        yield settings_key({part: config[part]}), partial(examine, title, *cases[part])
    for name in names:
        title = f"signature {Path(name).stem}"
        key = f"{title} {settings_key(config['world'])}"
        yield key, partial(_measured, title, name, config, case)
    for edit in (edit for name in edited for edit in with_parts(name, case)):
        title = f"edit {edit.name}"
        yield (
            f"{title} {settings_key(config['world'])}",
            partial(examine, title, edits.CHECKS, edits.EditCase(edit, case)),
        )


def with_parts(name: str, case: WorldCase) -> list[Edit]:
    """Return an edit, and those of its parts in a world."""
    check_own_edits(case.scenario.form)
    parts = () if "." in name else parts_of(name, case.scenario)
    return [find_edit(one, case.scenario) for one in (name, *(f"{name}.{part}" for part in parts))]


def _measured(title: str, name: str, config: Mapping[str, Any], case: WorldCase) -> list[Finding]:
    module = signatures.signature_module(name, case.scenario.form)
    return examine(title, signatures.SIGNATURE, signatures.case_with(config, case)(module))


def world_case(config: Mapping[str, Any], seed: int) -> WorldCase:
    """Return the case of a configuration's world, played by its model if that costs nothing."""
    chosen = policy_for(scenario_of(config), config["model"], seed)
    policy = None if chosen is None else build(chosen)
    schemas = config["model"].get("schemas") if config["model"].get("format") == "schema" else None
    return WorldCase(lambda: scenario_of(config), prompt_of(config), policy, schemas, seed)
