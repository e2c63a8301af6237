"""Checks of signatures: measures are described, repeatable, in their range, and NaN if nothing was decided."""

import inspect
import math
import pickle
import pkgutil
import re
import tempfile
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import chain
from numbers import Real
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from foundry.composing.baselines import Stage
from foundry.composing.preflight import check
from foundry.conformance.playing import POLICIES, Broken, Skipped, WorldCase, policy_for, require
from foundry.errors import InputError, not_found
from foundry.expansion import Condition, expand
from foundry.models.base import Model, Reply, Request
from foundry.own_code import OwnModule, ours, own_modules
from foundry.running.build import build
from foundry.running.local import LocalRunner, SweepJob
from foundry.storing.store import RunFolder, SweepFolder

SEEDS, NULL_SEEDS = (0, 1), tuple(range(20))
"""Seeds for most checks, and seeds for the runs of scripted/random that test the nulls of measures."""
FEWEST, LEVEL, SLIGHT = 6, 0.999, 0.01
"""For the comparison of means with nulls: minimum number of runs, confidence level, and tolerated difference.

The tolerated difference is a share of half the range of the measure.
"""
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_COUNT = "n_"
"""Prefix of measures that are counts, such as the number of decisions behind a share."""


class Silent(Model):
    """Gives empty replies to every question, so that no decision of a run is readable."""

    def __init__(self, name: str) -> None:
        self.name = name

    async def ask(self, request: Request) -> Reply:
        """Return an empty reply."""
        return Reply(text="")

    def parameters(self) -> dict[str, Any]:
        """Return no parameters."""
        return {}


@dataclass(frozen=True)
class SignatureCase:
    """A signature, with the runs for its checks.

    Attributes:
        runs: runs as arrays, in each class that `measure` may take.
        emptied: runs without readable decisions, in which no decision counts.
        blind: function that plays runs of scripted/random, and returns the arrays of each.
    """

    module: ModuleType
    runs: Sequence[Any]
    emptied: Sequence[Any]
    blind: Callable[[], Sequence[Sequence[Any]]] = tuple

    def taken(self, runs: Iterable[Any]) -> list[Any]:
        """Return the runs of the class that the signature measures; raise Skipped if there are none."""
        kind = run_type(self.module)
        taken = [run for run in runs if isinstance(run, kind)]
        if not taken:
            raise Skipped(
                f"the signature measures runs of the class {kind.__name__}, but this world has no such run: choose "
                "another world with world=NAME"
            )
        taken = [run for run in taken if getattr(self.module, "applies", lambda _: True)(run)]
        if not taken:
            raise Skipped("the signature does not apply to this world: choose another world with world=NAME")
        return taken

    def measured(self) -> list[dict[str, float]]:
        """Return the measures of each run."""
        return [self.module.measure(run) for run in self.taken(self.runs)]


def run_type(module: ModuleType) -> type:
    """Return the class of the runs that a signature's `measure` takes."""
    function = getattr(module, "measure", None)
    if not callable(function):
        raise Broken("it has no function `measure`: define measure(run: ...) -> dict[str, float]")
    names = list(inspect.signature(function).parameters)
    kind = typing.get_type_hints(function).get(names[0]) if names else None
    if not isinstance(kind, type):
        raise Broken("the argument of measure has no annotation: write measure(run: AnyRun) -> dict[str, float]")
    return kind


def says_what_it_is(case: SignatureCase) -> None:
    """The signature has a NAME, MEASURES with labels, and a HEADLINE that names some of these."""
    name = getattr(case.module, "NAME", None)
    is_name = isinstance(name, str) and _NAME.fullmatch(name) is not None
    require(is_name, f"NAME is {name!r}: use lower case letters, digits and _, as in the names of columns")
    measures = getattr(case.module, "MEASURES", None)
    described = isinstance(measures, Mapping) and all(getattr(measure, "label", "") for measure in measures.values())
    require(described, "MEASURES must map names to analysis.measure.Measure, each with a label")
    headline = getattr(case.module, "HEADLINE", ())
    require(isinstance(headline, tuple) and bool(headline), f"HEADLINE is {headline!r}: use a tuple of names")
    for measure_name in headline:
        require(
            any(_described(measure_name, measures or {})),
            f"HEADLINE contains '{measure_name}', which MEASURES does not describe",
        )


def says_what_it_takes(case: SignatureCase) -> None:
    """The argument of the function `measure` has an annotation: the class of the runs that it measures."""
    run_type(case.module)


def measures_what_it_describes(case: SignatureCase) -> str:
    """Every measure is a number within the range that MEASURES states; a note names measures that are always NaN."""
    rows = case.measured()
    for values in rows:
        require(isinstance(values, dict), f"measure returns {type(values).__name__}: return a dict of floats")
        for name, value in values.items():
            require(isinstance(value, Real), f"'{name}' is {value!r}: return a number")
            _check_range(name, value, case.module.MEASURES)
    absent = (
        [name for name in rows[0] if all(math.isnan(values.get(name, math.nan)) for values in rows)] if rows else []
    )
    each = "the only run" if len(rows) == 1 else f"all {len(rows)} runs"
    return f"not checked, because the value is NaN in {each} of this check: {', '.join(absent)}" if absent else ""


def _check_range(name: str, value: float, measures: Mapping[str, Any]) -> None:
    if name.startswith(_COUNT):
        require(value >= 0, f"the count '{name}' is {value:g}: use 0 or more")
        return
    measure: Any = next(_described(name, measures), None)
    require(
        measure is not None,
        f"'{name}' is not in MEASURES: describe it there, or begin its name with {_COUNT} if it is a count",
    )
    within = math.isnan(value) or (math.isfinite(value) and measure.low - 1e-9 <= value <= measure.high + 1e-9)
    require(within, f"'{name}' is {value:g}, but MEASURES states {measure.low:g} to {measure.high:g}")


def _described(name: str, measures: Mapping[str, Any]) -> Iterator[Any]:
    """Yield the entries of MEASURES that describe a measure: the entry with its name, and patterns such as `won_*`."""
    for pattern, measure in measures.items():
        start, star, end = pattern.partition("*")
        if name == pattern or (star and name.startswith(start) and name.endswith(end)):
            yield measure


def has_the_same_names_whatever_happened(case: SignatureCase) -> None:
    """All runs of a world have the same set of measures, also a run without a readable decision."""
    rows = [*case.measured(), *map(case.module.measure, case.taken(case.emptied))]
    first = rows[0]
    for other in rows:
        differing = ", ".join(sorted(set(first) ^ set(other)))
        require(
            not differing,
            f"measure() returns {differing} only for some runs: return it for every run, as NaN if it is undefined",
        )


def says_nan_for_nothing(case: SignatureCase) -> str | None:
    """If no decision counts, undefined measures are NaN, because a 0 would be a finding."""
    if not getattr(case.module, "READABLE_TOO", True):
        raise Skipped("READABLE_TOO is False, so all decisions count")
    zeros: set[str] = set()
    for run in case.taken(case.emptied):
        measures = {name: value for name, value in case.module.measure(run).items() if not name.startswith(_COUNT)}
        none = {name for name, value in measures.items() if value == 0}
        names = ", ".join(sorted(none))
        is_meant = not none or len(none) < len(measures)
        require(is_meant, f"{names} is 0 although no decision counts: return NaN, because 0 would be a finding")
        zeros |= none
    return f"check that 0 is right for {', '.join(sorted(zeros))} in runs without readable decisions" if zeros else None


def comes_to_its_nulls(case: SignatureCase) -> None:
    """If a measure states a null for scripted/random, its mean over runs of this policy is close to the null."""
    if not any(map(_is_of_random, case.module.MEASURES.values())):
        raise Skipped("no measure states a null for scripted/random")
    rows = [case.module.measure(case.taken(arrays)[0]) for arrays in case.blind()]
    stated: dict[str, tuple[Any, Any]] = {}
    for name in (name for name in rows[0] if not name.startswith(_COUNT)):
        measure = next(_described(name, case.module.MEASURES), None)
        values = np.array([row[name] for row in rows if not math.isnan(row.get(name, math.nan))])
        if _is_of_random(measure) and len(values) >= FEWEST:
            stated[name] = (measure, values)
    if not stated:
        raise Skipped("all measures with a null are NaN in this world: choose another world with world=NAME")
    for name, (measure, values) in stated.items():
        mean, allowed = float(values.mean()), _half_width(values, len(stated)) + SLIGHT * _unit(measure)
        is_null = abs(mean - measure.null.value) <= allowed
        require(
            is_null,
            f"'{name}' is {mean:.3f} on average over {len(values)} runs of scripted/random, but its Null is "
            f"{measure.null.value:g}. Chance explains at most {allowed:.3f} of the difference: correct the Null, or "
            "set by_random=False",
        )


def _is_of_random(measure: Any) -> bool:
    null = getattr(measure, "null", None)
    return null is not None and bool(null.by_random)


def _half_width(values: Any, rows: int) -> float:
    """Return half the width of a confidence interval of a mean, with Bonferroni's correction for `rows` measures."""
    from analysis.stats.intervals import student_quantile

    quantile = student_quantile(len(values) - 1, 1 - (1 - LEVEL) / rows)
    return quantile * float(values.std(ddof=1)) / math.sqrt(len(values))


def _unit(measure: Any) -> float:
    return (measure.high - measure.low) / 2 if math.isfinite(measure.high - measure.low) else 1.0


def measures_the_same_twice(case: SignatureCase) -> None:
    """Measuring a run again gives the same values."""
    for first, second in zip(case.measured(), case.measured(), strict=True):
        is_same = repr(first) == repr(second)
        require(is_same, f"measuring again gives {second} instead of {first}: use a generator with a fixed seed")


def leaves_the_run_as_it_is(case: SignatureCase) -> None:
    """Measuring does not change the run, because all signatures measure the same arrays."""
    for run in case.taken(case.runs):
        before = pickle.dumps(vars(run))
        case.module.measure(run)
        after = {name: value for name, value in vars(run).items() if name in pickle.loads(before)}
        require(pickle.dumps(after) == before, "measure changes the run: copy an array before writing into it")


def case_of(name: str, config: Mapping[str, Any], world: WorldCase) -> SignatureCase:
    """Return the data to check a signature in runs of a world; `name` is the signature's name or file."""
    module = _module(name, world.scenario.form)
    return case_with(config, world)(module)


def _module(name: str, form: str) -> ModuleType:
    own = {module.name: module for module in own_modules("signatures")}
    if name.endswith(".py") and Path(name).is_file():
        own[name] = OwnModule(Path(name).stem, name, Path(name).absolute())
    if name in own:
        module = own[name].load()
        ours("analysis.signature_modules").check_name(getattr(module, "NAME", ""), own[name].origin)
        return module
    shipped = dict(shipped_signatures(form))
    if name not in shipped:
        raise not_found("Signature", name, [*own, *shipped], "Name one, or its file, as in mine/signatures/greed.py.")
    return ours(shipped[name])


def shipped_signatures(form: str) -> Iterator[tuple[str, str]]:
    """Yield the name and the module of each shipped signature that measures worlds of this form."""
    rooms = Path(str(ours("analysis").__file__)).parent
    for room in ("any", form):
        for file in pkgutil.iter_modules([str(rooms / room / "signatures")]):
            yield file.name, f"analysis.{room}.signatures.{file.name}"


def case_with(config: Mapping[str, Any], world: WorldCase) -> Callable[[ModuleType], SignatureCase]:
    """Play runs of a world, and return a function that adds these runs to a signature for its checks."""
    policy = policy_for(world.scenario, config["model"], world.seed)
    if policy is None:
        raise InputError(f"No policy can play world '{world.scenario.name}': give its questions their `options`.")
    silent = {"_target_": f"{__name__}.{Silent.__name__}", "name": "silent"}
    played = _played(config, world, (policy, silent), SEEDS)
    runs, emptied = (list(chain.from_iterable(arrays)) for arrays in played)
    readable = [run.only_readable() for run in emptied]

    @cache
    def blind() -> Sequence[Sequence[Any]]:
        if not Stage(world.scenario, world.seed).suits(build(POLICIES[0])):
            raise Skipped(
                f"scripted/random cannot act in world '{world.scenario.name}': choose another world with world=NAME"
            )
        return _played(config, world, POLICIES[:1], NULL_SEEDS)[0]

    return lambda module: SignatureCase(module, runs, readable, blind)


def _played(
    config: Mapping[str, Any], world: WorldCase, models: Sequence[Mapping[str, Any]], seeds: tuple[int, ...]
) -> list[list[list[Any]]]:
    declared = world.scenario.declared()
    conditions = [Condition({"model": model["name"]}, {**config, "model": model}, seeds, declared) for model in models]
    sweep = expand(("check",), conditions)
    with tempfile.TemporaryDirectory() as path:
        answers = f"{path}/answers.sqlite"
        folder = SweepFolder.create(Path(path) / "sweep", sweep, {"cache": {"path": answers}}, [])
        LocalRunner(workers=1).run(SweepJob(folder, check(sweep), answers, 0))
        runs = [(run.run.condition, _arrays_of(run)) for run in folder.runs()]
    return [[arrays for place, arrays in runs if place == number] for number in range(len(models))]


def _arrays_of(run: RunFolder) -> list[Any]:
    from analysis.any.general import general_run
    from analysis.load import read_records, read_run

    summary = run.summary()
    if summary is None or summary.status != "complete":
        cause = summary.error if summary else "it did not end"
        raise InputError(f"No signature can be checked on run {run.id}, which failed: {cause}. Check its world first.")
    records = read_records(run, summary)
    general, own = general_run(run, records), read_run(run, records)
    return [own] if type(own) is type(general) else [own, general]
