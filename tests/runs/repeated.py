"""What came of calls that were made again, without a server."""

from foundry.storing.determinism import Repeat, RepeatResult, Repeats

CALLS = 10


def repeats(model: str, *, alone: int, loaded: int) -> Repeats:
    """Return ten calls of a model, so many of which came out the same; half of them decide something."""

    def again(number: int, equal: int) -> RepeatResult:
        alike = number < equal if number % 2 else None
        return RepeatResult(text=None if number < equal else "another", alike=alike)

    calls = tuple(
        Repeat(run="r", step=1, agent=n, kind="action", alone=again(n, alone), loaded=again(n, loaded))
        for n in range(CALLS)
    )
    measured = "2026-11-22T09:00:00+00:00"
    return Repeats(model=model, of=model, parameters={}, measured=measured, at_once=18, calls=calls)
