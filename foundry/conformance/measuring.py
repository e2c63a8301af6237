"""Finds a signature and plays the runs that it is tried on."""

from __future__ import annotations

import pkgutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from foundry.composing.preflight import check
from foundry.conformance.playing import WorldCase
from foundry.conformance.policies import policy_for
from foundry.conformance.signatures import SignatureCase
from foundry.errors import InputError, not_found
from foundry.expansion import Condition, expand
from foundry.own_code import OwnModule, ours, own_modules
from foundry.running.local import LocalRunner, SweepJob
from foundry.storing.store import RunFolder, SweepFolder

SEEDS = (0, 1)
_SILENT = {"_target_": "foundry.conformance.silent.Silent", "name": "silent"}


def signature_case(name: str, config: Mapping[str, Any], world: WorldCase) -> SignatureCase:
    """Return a signature with runs of a world to try it on.

    Args:
        name: its name, or its file.
        config: the condition whose world is played, its model if that costs nothing.
        world: the same world.

    Raises:
        InputError: there is no such signature, or it cannot be imported.
    """
    module = signature_module(name, world.scenario.form)
    return case_with(config, world)(module)


def case_with(config: Mapping[str, Any], world: WorldCase) -> Callable[[ModuleType], SignatureCase]:
    """Return what makes a case of a signature with runs of this world, which are played once."""
    with tempfile.TemporaryDirectory() as folder:
        spoken, silent = recorded_runs(Path(folder), config, world)
        runs = [run for one in spoken for run in arrays_of(one)]
        emptied = [run.only_readable() for one in silent for run in arrays_of(one)]
    return partial(SignatureCase, runs=runs, emptied=emptied)


def signature_module(name: str, form: str) -> ModuleType:
    """Return a signature's module: a file, one of the user's own, or a shipped one for this form or for any.

    Raises:
        InputError: there is none, it cannot be imported, or one of the user's own has a shipped name.
    """
    own = {one.name: one for one in own_modules("signatures")}
    if name.endswith(".py") and Path(name).is_file():
        own[name] = OwnModule(Path(name).stem, name, Path(name).absolute())
    if name in own:
        module = own[name].load()
        ours("analysis.finding").check_name(getattr(module, "NAME", ""), own[name].origin)
        return module
    shipped = dict(shipped_signatures(form))
    if name not in shipped:
        raise not_found("Signature", name, [*own, *shipped], "Name one, or its file, as in mine/signatures/greed.py.")
    return ours(shipped[name])


def shipped_signatures(form: str) -> Iterator[tuple[str, str]]:
    """Yield the names of the shipped signatures of a form and of any, and their modules' names."""
    rooms = Path(str(ours("analysis").__file__)).parent
    for room in ("any", form):
        for found in pkgutil.iter_modules([str(rooms / room / "signatures")]):
            yield found.name, f"analysis.{room}.signatures.{found.name}"


def recorded_runs(path: Path, config: Mapping[str, Any], world: WorldCase) -> tuple[list[RunFolder], list[RunFolder]]:
    """Play the world with the policy that answers in its checks, and with one that says nothing; return the runs."""
    policy = policy_for(world.scenario, config["model"], world.seed)
    if policy is None:
        raise InputError(f"No policy plays world '{world.scenario.name}': give its questions their `options`.")
    conditions = [
        Condition({"model": model["name"]}, {**config, "model": model}, SEEDS, world.scenario.declared())
        for model in (policy, _SILENT)
    ]
    sweep = expand(("check",), conditions)
    settings = {"cache": {"path": str(path / "answers.sqlite")}}
    folder = SweepFolder.create(path / "sweep", sweep, settings, [])
    LocalRunner(workers=1).run(SweepJob(folder, check(sweep), settings["cache"]["path"], 0))
    spoken, silent = ([run for run in folder.runs() if run.run.condition == place] for place in (0, 1))
    return spoken, silent


def arrays_of(run: RunFolder) -> list[Any]:
    """Return a run as arrays: as its form has it, and as any form has it.

    Raises:
        InputError: the run failed.
    """
    from analysis.any.general import general_run
    from analysis.load import read_records, read_run

    summary = run.summary()
    if summary is None or summary.status != "complete":
        cause = summary.error if summary else "it did not end"
        raise InputError(f"No signature can be tried on run {run.id}, which failed: {cause}. Check its world first.")
    records = read_records(run, summary)
    general = general_run(run, records)
    own = read_run(run, records)
    return [own] if type(own) is type(general) else [own, general]
