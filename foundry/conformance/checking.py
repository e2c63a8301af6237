"""Checks a user's own worlds, prompts, models, signatures and edits for `foundry check`."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
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

CHECKS: Mapping[str, Sequence[Check[Any]]] = {
    "world": (
        worlds.plays_to_its_end,
        worlds.asks_what_it_says,
        worlds.counts_its_calls,
        worlds.observes_plain_data,
        worlds.asks_without_side_effects,
        worlds.opens_without_side_effects,
        worlds.is_equal_from_equal_settings,
        worlds.is_equal_from_a_pickle,
        worlds.starts_afresh,
        worlds.asks_ahead_what_it_asks_later,
        worlds.follows_its_seed,
        worlds.has_a_persona_for_every_agent,
        worlds.tells_moments_apart_by_texts_and_flags,
        worlds.keeps_its_secrets,
        worlds.shows_images_where_it_says,
        worlds.declares_its_records,
        worlds.writes_what_it_declares,
        worlds.records_every_step,
        worlds.decides_as_declared,
        worlds.loads_its_records_back,
        worlds.opens_with_its_personas,
        worlds.redraws_what_it_drew,
        replies.survives_bad_replies,
        replies.takes_bad_replies_for_no_decision,
        replies.gives_the_same_when_played_again,
        replies.reads_the_options_it_offers,
        replies.reads_its_idle_reply,
        replies.has_a_template_for_every_question,
        replies.has_a_schema_for_every_question,
    ),
    "prompt": (
        prompts.has_every_kind,
        prompts.fills_every_question,
        prompts.names_what_is_observed,
        prompts.is_the_same_every_time,
        prompts.shows_the_images,
    ),
    "model": (
        models.says_its_name_and_kinds,
        models.answers_the_world,
        models.says_its_parameters,
        models.tells_its_settings_apart,
        models.answers_the_same,
        models.leaves_the_observation_as_it_is,
        models.refuses_other_kinds,
        models.fits_into_a_run,
    ),
    "signature": (
        signatures.says_what_it_is,
        signatures.says_what_it_takes,
        signatures.measures_what_it_describes,
        signatures.has_the_same_names_whatever_happened,
        signatures.says_nan_for_nothing,
        signatures.comes_to_its_nulls,
        signatures.measures_the_same_twice,
        signatures.leaves_the_run_as_it_is,
    ),
    "edit": (
        edits.changes_something,
        edits.asks_the_same,
        edits.keeps_what_templates_name,
        edits.leaves_its_input_as_it_is,
        edits.changes_the_same_every_time,
        edits.can_be_put,
        edits.expects_one_action_for_each,
    ),
}
"""The checks for each kind of part, in the order of the report. Checks of models ask only policies, which are free."""
CONFIGURED = ("world", "prompt", "model")
"""Kinds of parts that have a configuration group."""
EDIT = "edit="
"""Beginning of an argument that names edits; foundry reads such arguments without Hydra."""


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
    """Check all parts that a command line names, and return the findings."""
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
    return [finding for group in findings.values() for finding in group]


def _shared_out(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
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
    """Yield the key, title and kind of each part that is checked, and a function that makes the data for its checks."""
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
    """Return the edit `name`, and the edits `name.part` for each part of the observation that it can change alone."""
    check_own_edits(case.scenario.form)
    parts = () if "." in name else parts_of(name, case.scenario)
    return [find_edit(full, case.scenario) for full in (name, *(f"{name}.{part}" for part in parts))]


def world_case(config: Mapping[str, Any], seed: int) -> WorldCase:
    """Return the data for checks of a configuration's world. The model answers only if it costs nothing."""
    chosen = policy_for(scenario_of(config), config["model"], seed)
    return WorldCase(
        make=lambda: scenario_of(config),
        make_prompt=lambda: prompt_of(config),
        templates=config["prompt"].get("templates", {}),
        policy=None if chosen is None else build(chosen),
        schemas=config["model"].get("schemas") if config["model"].get("format") == "schema" else None,
        seed=seed,
    )
