"""Which runs of a sweep a page means, in a few letters."""

from __future__ import annotations

import base64

from foundry.errors import InputError


def places_in(mask: str, runs: int) -> list[int]:
    """Return the places of the runs that are meant.

    Args:
        mask: base64 (of addresses) of a bit a run, the first of a byte its highest.
        runs: how many runs there are.

    Raises:
        InputError: it is no mask of so many runs.
    """
    try:
        content = base64.b64decode(mask, altchars=b"-_", validate=True)
    except ValueError as error:
        raise InputError(f"'{mask[:40]}' does not say which rows are meant: {error}.") from error
    if len(content) != -(-runs // 8):
        raise InputError(f"The rows that are meant are those of {8 * len(content)} runs, and this sweep has {runs}.")
    return [place for place in range(runs) if content[place >> 3] & 128 >> (place & 7)]
