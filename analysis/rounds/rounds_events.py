"""Events of worlds in rounds: the first round in which agents decide differently, crowded evenings, a used-up stock."""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from analysis.measuring.events import Event, beginnings
from analysis.rounds.rounds_run import RoundsRun
from analysis.rounds.signatures import bar, fishery
from foundry.texts import first_of


def events(run: RoundsRun) -> Iterator[Event]:
    """Yield the events of a run."""
    for kind in dict.fromkeys(run.kind.tolist()):
        yield from _first_unlike(run, kind)
    if bar.applies(run):
        yield from _crowded(run)
    if fishery.applies(run):
        yield from _stock(run)


def _first_unlike(run: RoundsRun, kind: str) -> Iterator[Event]:
    own = (run.kind == kind) & run.readable
    by_step: dict[int, Counter[str]] = {}
    for step, label, number in zip(
        run.step[own].tolist(), run.action[own].tolist(), run.number[own].tolist(), strict=True
    ):
        by_step.setdefault(step, Counter())[f"{number:g}" if label is None else str(label)] += 1
    for step, choices in by_step.items():
        if len(choices) > 1:
            shown = first_of([f"{choice} ({count})" for choice, count in choices.most_common()], 4)
            yield Event(step, None, "first_unlike", f"agents decide differently on {kind}: {shown}")
            return


def _crowded(run: RoundsRun) -> Iterator[Event]:
    counts = run.counts(bar.KIND)
    goes = (run.choices(bar.KIND) == run.declared.actions[bar.KIND].labels.index(bar.GO)) & counts
    went, number = goes.sum(axis=1), counts.sum(axis=1)
    capacity = float(run.world["capacity"])
    for step in beginnings(np.asarray(went > capacity * number)):
        yield Event(step + 1, None, "crowded", f"the bar is crowded: {went[step]} of {number[step]} agents go")


def _stock(run: RoundsRun) -> Iterator[Event]:
    months = run.streams[fishery.STOCK]
    for month in months:
        if month["after"] == 0:
            yield Event(int(month["step"]), None, "stock_gone", f"the stock is gone: {month['before']} tons are caught")
            break
    if 0 < len(months) < run.world["steps"]:
        last = months[-1]
        text = f"the stock collapses: {last['after']} of {last['before']} tons are left"
        yield Event(int(last["step"]), None, "collapsed", text)
