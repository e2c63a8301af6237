"""The command that looks for the value of a setting from which an outcome prevails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import typer

from foundry.commands.application import EXIT_OK, OVERRIDES, RUN, Mine, Overrides, app, console, given, say
from foundry.commands.sweeps import composed_here, run_composed
from foundry.errors import InputError, not_found

if TYPE_CHECKING:
    from analysis.stats.threshold import Points, Search
    from foundry.composing.compose import Composed
    from foundry.expansion import Condition

FILE, POINTS_FILE = "threshold.csv", "threshold_points.csv"


class Asked(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The part `search` of a sweep's file.

    Attributes:
        setting: what is changed, such as `world.committed`.
        low: its least value.
        high: its greatest value.
        until: width of the bracket at which the search ends.
        measure: an outcome that is 0 or 1 in each run, `<signature>.<measure>`.
        level: share of runs above which it prevails.
        of: the setting of whose number the values are shares, such as `world.agents`; None where they are none.
    """

    setting: str
    low: float
    high: float
    until: float
    measure: str
    level: float = 0.5
    of: str | None = None

    def search(self, condition: Condition) -> Search:
        """Return what is looked for in a condition.

        Raises:
            InputError: `of` is no setting, or no number of things of which two counts lie between the ends.
        """
        from analysis.stats.threshold import Search

        of = None if self.of is None else _found(condition.config, self.of.split("."))
        if of is not None and (isinstance(of, bool) or not isinstance(of, int) or of < 1):
            raise InputError(f"search.of={self.of} is {of}: name a setting that is a whole number from 1.")
        search = Search(self.low, self.high, self.until, self.level, of)
        low, high = search.ends
        if not low < high:
            raise InputError(
                f"No two whole counts of {self.of}={of} lie at search.low={self.low} and search.high={self.high}."
            )
        return search


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def threshold(overrides: Overrides = None, config_dir: Mine = None) -> None:
    """Look for the value of a setting from which an outcome prevails, by bisection, for each model of a sweep.

    Takes what `foundry` takes: foundry threshold +sweep=critical_mass model=llama3.2 seed=0-9
    """
    from foundry.composing.preparing import OUTPUTS
    from foundry.storing.store import fresh_folder

    composed = composed_here(["-m", *given(overrides, config_dir)])
    if composed is None:
        return
    asked = _asked(composed)
    named = composed.settings["output"]["dir"]
    folder = Path(named) if named else fresh_folder(OUTPUTS)
    points, code = _played(composed, asked, folder)
    if code == EXIT_OK:
        _tell(composed.conditions, asked, points, folder)
    raise typer.Exit(code)


def _asked(composed: Composed) -> Asked:
    """Return what a sweep says of its search.

    Raises:
        InputError: it says nothing, or what it says cannot be.
    """
    found = composed.settings.get("search")
    if found is None:
        raise InputError(
            "This sweep looks for no threshold: its file needs a part `search`, as +sweep=critical_mass has."
        )
    try:
        asked = msgspec.convert(found, Asked)
    except msgspec.ValidationError as error:
        raise InputError(f"search={found} says nothing that can be looked for: {error}.") from error
    if not (asked.low < asked.high and asked.until > 0 and 0 < asked.level < 1):
        raise InputError(f"search={found}: give low < high, until > 0 and a level between 0 and 1.")
    for condition in composed.conditions:
        _changed(condition.config, asked.setting.split("."), asked.low)
        asked.search(condition)
    return asked


def _played(composed: Composed, asked: Asked, folder: Path) -> tuple[list[dict[float, Any]], int]:
    """Play stage after stage, each a sweep of one value a condition; return the outcomes by condition and value."""
    from analysis.stats.threshold import next_value

    searches = [asked.search(condition) for condition in composed.conditions]
    points: list[dict[float, Any]] = [{} for _ in composed.conditions]
    stage = 0
    while wanted := {
        place: value
        for place, (search, one) in enumerate(zip(searches, points, strict=True))
        if (value := next_value(search, one)) is not None
    }:
        stage += 1
        path = folder / f"stage-{stage}"
        conditions = [_with_value(composed.conditions[one], asked.setting, value) for one, value in wanted.items()]
        code = run_composed(_stage(composed, conditions, path))
        if code != EXIT_OK:
            return points, code
        for (place, value), outcomes in zip(wanted.items(), _outcomes(path, asked.measure, len(wanted)), strict=True):
            points[place][value] = outcomes
    return points, EXIT_OK


def _stage(composed: Composed, conditions: Sequence[Condition], path: Path) -> Composed:
    settings = {key: value for key, value in composed.settings.items() if key != "search"}
    settings |= {"output": {"dir": str(path)}, "analyze": False}
    return replace(composed, conditions=tuple(conditions), settings=settings)


def _with_value(condition: Condition, setting: str, value: float) -> Condition:
    factors = {**condition.factors, setting: value}
    return replace(condition, factors=factors, config=_changed(condition.config, setting.split("."), value))


def _changed(config: Mapping[str, Any], keys: Sequence[str], value: float) -> dict[str, Any]:
    """Return a configuration with another value at one place.

    Raises:
        InputError: there is no such place.
    """
    first, *rest = keys
    if first not in config or (rest and not isinstance(config[first], Mapping)):
        raise not_found("Setting of the search", first, config)
    return {**config, first: _changed(config[first], rest, value) if rest else value}


def _found(config: Mapping[str, Any], keys: Sequence[str]) -> Any:
    """Return what a configuration says at one place.

    Raises:
        InputError: there is no such place.
    """
    first, *rest = keys
    if first not in config or (rest and not isinstance(config[first], Mapping)):
        raise not_found("Setting of the search", first, config)
    return _found(config[first], rest) if rest else config[first]


def _outcomes(path: Path, measure: str, conditions: int) -> list[Any]:
    """Return the outcomes of the runs of each condition, (runs,) each; those in which it is undefined left out.

    Raises:
        InputError: the measure does not exist, is no outcome, or is defined in no run of a condition.
    """
    import numpy as np

    from analysis.measuring.runs import Source, measure_run
    from foundry.storing.store import SweepFolder

    found: list[list[float]] = [[] for _ in range(conditions)]
    source = Source(path, path.name)
    for run in SweepFolder.open(path).runs():
        measures = measure_run(run, source).measures
        if measure not in measures:
            raise not_found("Measure of the search", measure, measures)
        found[run.run.condition].append(measures[measure])
    outcomes = [np.array([value for value in values if not np.isnan(value)]) for values in found]
    for one in outcomes:
        if not one.size or not np.isin(one, (0, 1)).all():
            raise InputError(f"{measure} is no outcome in {path}: a search needs a measure that is 0 or 1 in each run.")
    return outcomes


def _tell(conditions: Sequence[Condition], asked: Asked, points: Sequence[Points], folder: Path) -> None:
    """Write the tables, and show the one that says what was found."""
    import numpy as np
    import pandas as pd

    from analysis.stats.threshold import share_of
    from analysis.stats.threshold import threshold as found_by
    from analysis.tables.texts import spreadsheet_frame
    from foundry.display import frame_table

    rows, played = [], []
    for condition, one in zip(conditions, points, strict=True):
        names = {"model": condition.config["model"]["name"], "prompt": condition.config["prompt"]["name"]}
        names |= {key: value for key, value in condition.factors.items() if key not in names}
        search = asked.search(condition)
        found = found_by(search, one)
        ends = {"low": found.low, "high": found.high, "surely_low": found.surely_low, "surely_high": found.surely_high}
        asked_for = {"setting": asked.setting, "measure": asked.measure, "threshold": found.at}
        if search.of is not None:
            counts = np.rint(np.array([found.low, found.high]) * search.of).tolist()
            ends |= dict(zip(("low_count", "high_count"), counts, strict=True))
        rows.append({**names, **asked_for, **ends, "values": len(one)})
        for value, outcomes in sorted(one.items()):
            share, low, high = share_of(outcomes)
            played.append({**names, asked.setting: value, "n": len(outcomes), "share": share, "low": low, "high": high})
    spreadsheet_frame(pd.DataFrame(rows)).to_csv(folder / FILE, index=False)
    spreadsheet_frame(pd.DataFrame(played)).to_csv(folder / POINTS_FILE, index=False)
    columns = tuple(rows[0])
    shown = [tuple(f"{one:.3g}" if isinstance(one, float) else str(one) for one in row.values()) for row in rows]
    console().print(frame_table(shown, columns))
    say(f"{folder / FILE}: the bracket of the bisection (low, high), and the nearest values whose whole 95 % interval")
    say(f"lies on one side (surely_low, surely_high); {folder / POINTS_FILE} has every value that was played")
    if asked.of is not None:
        say(f"low_count, high_count: the bracket of {asked.of}; nothing lies between two neighbouring counts")
