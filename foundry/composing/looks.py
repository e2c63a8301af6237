"""A sweep that was declared, look after look: `until=answered`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from foundry.composing.compose import Composed
from foundry.composing.settings import UNTIL
from foundry.errors import InputError
from foundry.expansion import expand
from foundry.storing.preregistration import PREREGISTRATION_FILE, Preregistration, preregistration_of
from foundry.storing.store import SweepFolder, is_sweep


def stages(composed: Composed) -> list[Composed]:
    """Return what is to be run until each look of the plan, which is in the folder that was asked for.

    Each is a sweep of the first seeds of the plan, which grows into the next one.

    Raises:
        InputError: nothing was declared, or something else than is asked for.
    """
    plan = _plan(composed)
    ids = {run.id for run in expand(composed.asked, composed.conditions).runs}
    if ids != plan.runs.keys():
        raise InputError(
            f"{UNTIL}=answered runs what was declared: of {len(plan.runs)} runs in {PREREGISTRATION_FILE} "
            f"{len(plan.runs.keys() - ids)} are not asked for, and {len(ids - plan.runs.keys())} are asked for beside "
            "them. Repeat the overrides that it was made with."
        )
    return [replace(one, settings={**one.settings, UNTIL: None}) for one in _parts(composed, plan)]


def _plan(composed: Composed) -> Preregistration:
    folder = composed.settings["output"]["dir"]
    found = preregistration_of(Path(folder)) if folder else None
    if found is None:
        where = f"'{folder}' has none" if folder else "no output.dir is named"
        raise InputError(
            f"{UNTIL}=answered stops at a look of {PREREGISTRATION_FILE}, and {where}: foundry preregister makes it."
        )
    if is_sweep(Path(folder)) and SweepFolder.open(folder).plan != found[1]:
        raise InputError(
            f"The sweep in '{folder}' did not begin with the plan that is there, so no look of it counts: preregister "
            "and run it in another output.dir."
        )
    return found[0]


def _parts(composed: Composed, plan: Preregistration) -> Iterator[Composed]:
    for look in plan.looks:
        own = set(plan.seeds[: look.seeds])
        parts = (replace(one, seeds=tuple(seed for seed in one.seeds if seed in own)) for one in composed.conditions)
        yield replace(composed, conditions=tuple(one for one in parts if one.seeds))
