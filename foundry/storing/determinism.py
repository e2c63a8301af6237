"""The results of repeating recorded calls, which show whether a server gives the same reply again."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec

from foundry.expansion import is_served, leaves, settings_key
from foundry.records import RunSummary
from foundry.storing.run_files import json_file, storing, write_atomically
from foundry.storing.store import RunFolder, SweepFolder
from foundry.texts import visible

DETERMINISM_FILE = "determinism.json"
SETTING = "determinism"
"""The setting for the number of calls of each served model that are repeated; 0 repeats none."""
AUTO = "auto"
"""Value of the setting `determinism`: send about 2 % of each served model's calls again."""
_CALLS_PER_REPEAT = 50
_LEAST, _MOST = 2, 10
"""Minimum and maximum number of recorded calls of a model that `determinism=auto` repeats."""


@dataclass(frozen=True)
class Budget:
    """The number of calls that measure whether a model is deterministic.

    Attributes:
        again: number of recorded calls that are repeated, once alone and once under load.
        beside: number of further recorded calls that are sent at the same time, as load.
    """

    again: int
    beside: int

    @classmethod
    def of(cls, setting: int | str, calls: int, in_flight: int) -> "Budget":
        """Return how many calls to repeat and to add as load. In all, `auto` sends 2 % of the calls, but at least 4."""
        if isinstance(setting, int):
            again = min(setting, calls)
            return cls(again, min(in_flight, calls - again))
        further = max(2 * _LEAST, calls // _CALLS_PER_REPEAT)
        again = min(calls, _MOST, max(_LEAST, further // 3))
        return cls(again, min(in_flight, calls - again, further - 2 * again))


class RepeatResult(msgspec.Struct, frozen=True, kw_only=True):
    """The result of a repeated call.

    Attributes:
        text: text of the new reply; null if its text and ending equal those of the recorded reply.
        alike: whether the decision equals the recorded one; null if the call decides nothing alone, as in talk.
    """

    text: str | None = None
    alike: bool | None = None


class Repeat(msgspec.Struct, frozen=True, kw_only=True):
    """The results of repeating a recorded call, alone and under load."""

    run: str
    step: int
    agent: int
    kind: str
    alone: RepeatResult
    loaded: RepeatResult


class Share(msgspec.Struct, frozen=True):
    """The number of repeated replies (`of`), and how many of them were equal to the recorded replies (`equal`)."""

    equal: int
    of: int

    def __str__(self) -> str:
        return f"{self.equal} of {self.of}"


class Score(msgspec.Struct, frozen=True):
    """The share of repeated calls with an equal text, and the share with an equal decision among calls that decide."""

    texts: Share
    decisions: Share


class Repeats(msgspec.Struct, frozen=True, kw_only=True):
    """The repeated calls of a served model (`determinism.json`).

    Attributes:
        of: name of the model in tables; a member of a population has the population's name.
        parameters: all settings of the calls that affect answers, except messages and seed.
        measured: time of the measurement, ISO 8601, UTC.
        at_once: number of calls that were sent at the same time as load.
    """

    model: str
    of: str
    parameters: dict[str, Any]
    measured: str
    at_once: int
    calls: tuple[Repeat, ...]

    @property
    def alone(self) -> Score:
        """The shares of equal texts and decisions when the calls were repeated one after another."""
        return _score([call.alone for call in self.calls])

    @property
    def loaded(self) -> Score:
        """The shares of equal texts and decisions when the calls were repeated at the same time."""
        return _score([call.loaded for call in self.calls])

    @property
    def least(self) -> Share:
        """The share of equal texts when calls were repeated alone or under load, whichever share is smaller."""
        return min(self.alone.texts, self.loaded.texts, key=lambda share: share.equal)

    @property
    def exact(self) -> bool:
        """True if every repeated call gave the recorded text."""
        return self.least.equal == self.least.of

    def line(self) -> str:
        """Return, in words, how many repeated calls gave the same text and the same decision."""
        alone, loaded = self.alone, self.loaded
        score = f"same text in {alone.texts} calls sent alone, and in {loaded.texts} calls sent {self.at_once} at once"
        if not alone.decisions.of:
            return f"{score}; decisions were not compared, because these calls have none"
        return f"{score}; same decision in {alone.decisions} calls sent alone, and in {loaded.decisions} sent at once"


def _score(repeats: Sequence[RepeatResult]) -> Score:
    decisions = [repeat.alike for repeat in repeats if repeat.alike is not None]
    return Score(
        Share(sum(repeat.text is None for repeat in repeats), len(repeats)), Share(sum(decisions), len(decisions))
    )


def inexact(repeats: Iterable[Repeats]) -> dict[str, str]:
    """Return, by the model's name in tables, a remark for each model whose server did not repeat all calls exactly."""
    least_last = sorted(
        (repeat for repeat in repeats if not repeat.exact),
        key=lambda repeated: -repeated.least.equal / repeated.least.of,
    )
    worst = {repeated.of: repeated for repeated in least_last}
    return {
        name: f"{repeated.model}'s server repeats {repeated.least} calls exactly" for name, repeated in worst.items()
    }


class _File(msgspec.Struct):
    models: tuple[Repeats, ...]


def is_measured(repeats: Iterable[Repeats], of: str, model: str, parameters: Mapping[str, Any]) -> bool:
    """Return whether a model was measured with these parameters; `of` is the name of the model in tables."""
    key = settings_key(parameters)
    return any(
        (measured.of, measured.model, settings_key(measured.parameters)) == (of, model, key) for measured in repeats
    )


def answered_calls(summary: RunSummary, served: Collection[str]) -> int:
    """Return how many calls of a run were answered by servers of the models in `served`.

    For a population, all agents are assumed to have made equally many calls.
    """
    agents = sum(len(member.agents) for member in summary.members)
    served_agents = sum(len(member.agents) for member in summary.members if member.model in served)
    calls = summary.counts.calls * served_agents // agents if agents else summary.counts.calls
    return max(0, calls - summary.counts.cached)


def repeats_of(folder: SweepFolder) -> tuple[Repeats, ...]:
    """Return, for each served model of a sweep, how alike its repeated calls were."""
    content = json_file(folder.path / DETERMINISM_FILE, _File)
    return () if content is None else content.models


def write_repeats(folder: SweepFolder, repeats: Sequence[Repeats]) -> None:
    """Write, for each served model of a sweep, how alike its repeated calls were."""
    content = msgspec.json.format(msgspec.json.encode(_File(tuple(repeats))), indent=1)
    with storing(folder.path / DETERMINISM_FILE):
        write_atomically(folder.path / DETERMINISM_FILE, content + b"\n")


@dataclass(frozen=True)
class ModelRepeats:
    """The name of a served model, and its measurement or the reason why it was not measured."""

    name: str
    repeats: Repeats | None
    why: str = ""

    def line(self) -> str:
        """Return the result in one line, with control characters escaped."""
        said = f"determinism not measured: {self.why}" if self.repeats is None else self.repeats.line()
        return f"{visible(self.name)}: {said}"


def model_repeats(folder: SweepFolder) -> list[ModelRepeats]:
    """Return what the check of determinism found for each served model, or why it did not measure the model."""
    measured = repeats_of(folder)
    lines = [ModelRepeats(name, repeated) for name, repeated in zip(_names(measured), measured, strict=True)]
    if not folder.settings.get(SETTING):
        return lines
    named = {
        str(condition.config["model"]["name"])
        for condition in folder.sweep.conditions
        if is_served(condition.config["model"])
    }
    left = named - {repeated.of for repeated in measured}
    having: dict[str, list[RunFolder]] = {name: [] for name in sorted(left)}
    for run in folder.runs() if left else []:
        having.get(str(folder.sweep.conditions[run.run.condition].config["model"]["name"]), []).append(run)
    return lines + [ModelRepeats(name, None, _why(runs)) for name, runs in having.items()]


def _why(runs: Iterable[RunFolder]) -> str:

    summaries = [run.summary() for run in runs]
    complete = [summary for summary in summaries if summary is not None and summary.status == "complete"]
    if len(complete) < len(summaries):
        return "not all of its runs are complete"
    if all(summary.counts.cached == summary.counts.calls for summary in complete):
        return "every answer came from the cache"
    return "its calls were not repeated"


def _names(measured: Sequence[Repeats]) -> list[str]:
    """Return a name for each measured model. For models with the same name, add the settings in which they differ."""
    settings = [dict(leaves(repeated.parameters)) for repeated in measured]
    names = []
    for model, own in zip(measured, settings, strict=True):
        others = [other for other, of in zip(settings, measured, strict=True) if of.model == model.model]
        differing = [f"{key}={own[key]}" for key in own if any(other.get(key) != own[key] for other in others)]
        names.append(f"{model.model} ({', '.join(differing)})" if differing else model.model)
    return names
