"""The checks of each kind of part, for `foundry check world=mine` and `foundry.check("world=mine")`."""

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from foundry import own_code
from foundry.calling import off_the_loop
from foundry.composing.compose import compose
from foundry.composing.preflight import prompt_of, scenario_of
from foundry.conformance import edits, models, prompts, replies, signatures, worlds
from foundry.conformance.playing import Check, Finding, WorldCase, examine, policy_for
from foundry.errors import InputError
from foundry.expansion import settings_key
from foundry.running.build import build
from foundry.worlds.probe.editing import Edit, check_own_edits, find_edit, parts_of


def _checks(case: type, *modules: ModuleType) -> tuple[Check[Any], ...]:
    """Return the public functions of modules that take only a case of this class, in the order of their definition."""
    own = (
        one for module in modules for one in vars(module).values() if getattr(one, "__module__", "") == module.__name__
    )
    functions = (one for one in own if inspect.isfunction(one) and not one.__name__.startswith("_"))
    return tuple(one for one in functions if [*inspect.get_annotations(one).values()][:-1] == [case])


CHECKS: Mapping[str, Sequence[Check[Any]]] = {
    "world": _checks(WorldCase, worlds, replies),
    "prompt": _checks(WorldCase, prompts),
    "model": _checks(models.ModelCase, models),
    "signature": _checks(signatures.SignatureCase, signatures),
    "edit": _checks(edits.EditCase, edits),
}
"""The checks of each kind of part, in order; checks of models call only policies."""
CONFIGURED = ("world", "prompt", "model")
"""Kinds of parts with a configuration."""
EDIT = "edit="
"""Prefix of edits, which have no configuration."""


def check(*asked: str, config_dir: Path | str | None = None) -> tuple[Finding, ...]:
    """Check your own parts: `foundry.check("world=mine", config_dir="mine")`.

    Args:
        asked: overrides for the parts to check, such as `world=mine`, `model=mine`, `prompt=mine` or `edit=mine`, and
            signatures by name or file.
        config_dir: folder of your own worlds, prompts and models, and of their code.

    Returns:
        The findings of the checks; `status` is `failed` if something must be fixed.

    Raises:
        InputError: a part does not exist or cannot be built.
    """
    folder = [] if config_dir is None else ["--config-dir", str(config_dir)]
    return off_the_loop(lambda: tuple(check_asked([*asked, *folder])))


def check_asked(arguments: Sequence[str]) -> list[Finding]:
    """Return the findings about all parts that a command line names."""
    edited = [name for text in arguments if text.startswith(EDIT) for name in text.removeprefix(EDIT).split(",")]
    overrides, measured = _shared_out([text for text in arguments if not text.startswith(EDIT)])
    chosen = [kind for kind in CONFIGURED if any(text.lstrip("+").startswith(f"{kind}=") for text in overrides)]
    if not chosen and not measured and not edited:
        raise InputError("Nothing to check: name it, as in foundry check world=mine, or a signature by name or file.")
    composed = compose(["-m", *overrides])
    findings: dict[str, list[Finding]] = {}
    for condition in composed.conditions if composed else ():
        for key, title, kind, case in _cases(condition.config, condition.seeds[0], (chosen, measured, edited)):
            if key not in findings:
                findings[key] = examine(title, CHECKS[kind], case())
    return [finding for found in findings.values() for finding in found]


def _shared_out(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split arguments into overrides with flags, and names of signatures."""
    overrides: list[str] = []
    names: list[str] = []
    is_folder = False
    for argument in arguments:
        is_name = not is_folder and "=" not in argument and not argument.startswith(("-", "~"))
        (names if is_name else overrides).append(argument)
        is_folder = argument in own_code.CONFIG_DIR
    return overrides, names


def _cases(
    config: Mapping[str, Any], seed: int, asked: tuple[Sequence[str], Sequence[str], Sequence[str]]
) -> Iterator[tuple[str, str, str, Callable[[], Any]]]:
    """Yield a key, a title, the kind and the function that makes the case, for each part to check."""
    case, (chosen, measured, edited) = world_case(config, seed), asked
    cases = {"world": case, "prompt": case, "model": models.ModelCase(build, config["model"], case)}
    for kind in chosen:
        yield settings_key({kind: config[kind]}), f"{kind} {config[kind]['name']}", kind, partial(cases.get, kind)
    world = settings_key(config["world"])
    for name in measured:
        title = f"signature {Path(name).stem}"
        yield f"{title} {world}", title, "signature", partial(signatures.case_of, name, config, case)
    for edit in (edit for name in edited for edit in with_parts(name, case)):
        title = f"edit {edit.name}"
        yield f"{title} {world}", title, "edit", partial(edits.EditCase, edit, case)


def with_parts(name: str, case: WorldCase) -> list[Edit]:
    """Return an edit, and the edits of its parts in a world."""
    check_own_edits(case.scenario.form)
    parts = () if "." in name else parts_of(name, case.scenario)
    return [find_edit(full, case.scenario) for full in (name, *(f"{name}.{part}" for part in parts))]


def world_case(config: Mapping[str, Any], seed: int) -> WorldCase:
    """Return the case of a configuration's world; its model plays if the model costs nothing."""
    chosen = policy_for(scenario_of(config), config["model"], seed)
    return WorldCase(
        make=lambda: scenario_of(config),
        make_prompt=lambda: prompt_of(config),
        templates=config["prompt"].get("templates", {}),
        policy=None if chosen is None else build(chosen),
        schemas=config["model"].get("schemas") if config["model"].get("format") == "schema" else None,
        seed=seed,
    )
