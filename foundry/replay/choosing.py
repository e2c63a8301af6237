"""Selects the steps to show."""

import re

from foundry.errors import InputError

_PART = re.compile(r"(\d+)(?:-(\d+))?")


def chosen_steps(text: str | None, every: int | None, last: int) -> list[int]:
    """Return the steps to show, ascending; 0 is the initial state.

    Args:
        text: numbers and ranges such as "0,5,10-20", or None for all steps.
        every: n, for the initial state and every n-th step after it, or None.
        last: number of the last step.

    Raises:
        InputError: the text cannot be read, or names a missing step.
    """
    if text is not None and every is not None:
        raise InputError("--steps and --every exclude each other. Give one of them.")
    if every is not None:
        if every < 1:
            raise InputError(f"--every {every} is not a valid number of steps. Give a number of at least 1.")
        return list(range(0, last + 1, every))
    if text is None:
        return list(range(last + 1))
    return sorted({step for part in text.split(",") for step in _steps_of(part.strip(), last)})


def _steps_of(part: str, last: int) -> range:
    match = _PART.fullmatch(part)
    if match is None:
        raise InputError(f"--steps: '{part}' is neither a step nor a range such as 10-20.")
    first, final = int(match[1]), int(match[2] or match[1])
    if first > final:
        raise InputError(f"--steps: the range '{part}' runs backwards.")
    if final > last:
        raise InputError(f"--steps: there is no step {final}; the records end with step {last}.")
    return range(first, final + 1)
