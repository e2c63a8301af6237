"""Checks by canaries that the same weights answered all runs of a sweep."""

from collections.abc import Iterable, Iterator

from foundry.canary import Canary, Distance, Verdict
from foundry.errors import RecordError
from foundry.records import RunSummary
from foundry.storing.store import RunFolder


def weights_apart(runs: Iterable[RunFolder]) -> Iterator[str]:
    """Yield a line for each run that has, or may have, answers of other weights than the first run of its model."""
    first: dict[str, tuple[str, Canary]] = {}
    for summary in _summaries(runs):
        for canary in summary.canaries:
            run, begun = first.setdefault(canary.model, (summary.run, canary))
            distance = Distance.between(begun.signs, canary.signs)
            if distance.verdict is Verdict.OTHER:
                yield f"{summary.run}: answers of other weights of '{canary.model}' than in {run}: {distance}"
            elif canary.verdict is Verdict.OTHER:
                yield f"{summary.run}: answers of other weights of '{canary.model}' in between: {canary.distance}"


def _summaries(runs: Iterable[RunFolder]) -> Iterator[RunSummary]:
    for run in runs:
        try:
            summary = run.summary()
        except RecordError:  # the run's own verdict reports it
            continue
        if summary is not None:
            yield summary
