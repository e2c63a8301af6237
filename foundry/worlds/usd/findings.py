"""What a scene's file holds that cannot be drawn or resolved: each kind is named once."""

from __future__ import annotations

from collections.abc import Iterator


class Findings:
    """Counts things by kind; the first of each kind is named as the example."""

    def __init__(self) -> None:
        self._seen: dict[str, list[str]] = {}

    def add(self, kind: str, example: str) -> None:
        """Note one more thing of this kind, found at `example`; the same example counts once."""
        examples = self._seen.setdefault(kind, [])
        if example not in examples:
            examples.append(example)

    def lines(self) -> Iterator[str]:
        """Yield one line for each kind, in the order in which they were found."""
        for kind, examples in self._seen.items():
            more = f" and {len(examples) - 1} more" if len(examples) > 1 else ""
            yield f"{kind}: {examples[0]}{more}"
