"""What a scene's file holds that cannot be drawn or resolved: each kind is named once."""

from __future__ import annotations

from collections.abc import Iterator

EXAMPLES = 5


class Findings:
    """Counts things by kind; the first few of each kind are named."""

    def __init__(self) -> None:
        self._seen: dict[str, dict[str, None]] = {}

    def add(self, kind: str, example: str) -> None:
        """Note one more thing of this kind, found at `example`; the same example counts once."""
        self._seen.setdefault(kind, {})[example] = None

    def lines(self) -> Iterator[str]:
        """Yield one line for each kind, in the order in which they were found."""
        for kind, examples in self._seen.items():
            rest = len(examples) - EXAMPLES
            more = f" and {rest} more" if rest > 0 else ""
            yield f"{kind}: {'; '.join(list(examples)[:EXAMPLES])}{more}"
