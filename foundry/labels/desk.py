"""Gives the texts of a sample to people, one at a time, and writes each label to the disk before it is confirmed."""

import hashlib
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping

import msgspec

from foundry.errors import InputError
from foundry.labels.definition import UNCLEAR, YES, Label
from foundry.labels.folder import Entry, LabelFolder
from foundry.labels.items import content_of
from foundry.labels.sampling import Sample, SampledText

_LETTERS = {YES: "y", "no": "n", UNCLEAR: "u"}


class ShownText(msgspec.Struct, frozen=True, kw_only=True):
    """A text to label, with all that the person sees beside it.

    Attributes:
        question: the line of the label's question that has a question mark.
        guidance: the other lines of the label's question.
        told: the prompt that the agent got; "" if there is none, or if the question already contains it.
        choices: for each answer, the key to press and the name.
    """

    item: str
    text: str
    question: str
    guidance: tuple[str, ...]
    told: str
    choices: tuple[tuple[str, str], ...]


class Place(msgspec.Struct, frozen=True, kw_only=True):
    """The progress of a person through the sample.

    Attributes:
        shown: text to label now; None if the person has labelled all texts.
        done: number of texts that the person labelled.
        total: number of texts in the sample.
        can_undo: whether there is a label to undo.
    """

    shown: ShownText | None
    done: int
    total: int
    can_undo: bool


class LabelDesk:
    """The texts of a sample and the labels of all people, which several threads may use at once.

    A person's next text is one of the texts that the fewest other people have labelled or see now. Among these, each
    person has a separate order, which takes one text of every stratum in turn. So two people begin with different
    texts, and a person who stops early has labelled texts of every stratum.
    """

    def __init__(
        self, folder: LabelFolder, label: Label, sample: Sample, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Read the labels that people have given so far; `clock` returns the present time in seconds."""
        self._folder, self._label, self._clock = folder, label, clock
        self._drawn = {drawn.item: drawn for drawn in sample.drawn}
        self._lock = threading.Lock()
        self._labels = {person: folder.labels_by(person) for person in folder.people()}
        self._now: dict[str, tuple[str, float]] = {}
        same: dict[bytes, list[str]] = {}
        for text in sample.drawn:
            same.setdefault(content_of(text.text, text.context), []).append(text.item)
        self._same = {item: items for items in same.values() for item in items}

    def place(self, person: str) -> Place:
        """Return how many texts a person has labelled, and the text to label now."""
        with self._lock:
            return self._place(person)

    def label(self, person: str, item: str, label: str) -> Place:
        """Store a person's label of the text that the person sees; when this returns, the label is on the disk.

        Raises:
            InputError: the person sees another text, or the label is not one of the choices.
        """
        with self._lock:
            shown, since = self._now.get(person, ("", 0.0))
            if item != shown:
                raise InputError("This text is no longer shown: reload the page to continue.")
            options = (*self._label.options(self._drawn[item].context), UNCLEAR)
            if label not in options:
                raise InputError(f"'{label}' is not an answer to this question: choose {', '.join(options)}.")
            self._add(person, item, label, round(self._clock() - since, 3))
            del self._now[person]
            return self._place(person)

    def undo(self, person: str) -> Place:
        """Undo the last label of a person and show its text again.

        Raises:
            InputError: there is no label to undo.
        """
        with self._lock:
            labels = self._known(person)
            if not labels:
                raise InputError("There is no label to undo.")
            item = next(reversed(labels))
            self._add(person, item, None, None)
            self._now[person] = item, self._clock()
            return self._place(person)

    def done(self) -> Mapping[str, int]:
        """Return the number of texts that each person has labelled, by name."""
        with self._lock:
            return {person: self._count(person) for person in sorted(self._labels)}

    def _place(self, person: str) -> Place:
        labels = self._known(person)
        if person not in self._now and (item := self._next(person)) is not None:
            self._now[person] = item, self._clock()
        now = self._now.get(person)
        return Place(
            shown=None if now is None else self._shown(self._drawn[now[0]]),
            done=self._count(person),
            total=len(self._drawn),
            can_undo=bool(labels),
        )

    def _next(self, person: str) -> str | None:
        mine = self._labels[person]
        others = Counter(item for name, labels in self._labels.items() if name != person for item in labels)
        others.update(item for name, (item, _) in self._now.items() if name != person)
        order = {item: place for place, item in enumerate(self.order(person))}
        left = [item for item in order if item not in mine]
        return min(left, key=lambda item: (others[item], order[item]), default=None)

    def order(self, person: str) -> list[str]:
        """Return all texts in one person's order: in turn one of each stratum, in random order within a stratum."""
        drawn_by = {item: hashlib.sha256(f"{person}/{item}".encode()).digest() for item in self._drawn}
        ranks: Counter[int] = Counter()
        rounds: dict[str, tuple[int, bytes]] = {}
        for item in sorted(self._drawn, key=lambda item_id: drawn_by[item_id]):
            stratum = self._drawn[item].stratum
            rounds[item] = ranks[stratum], drawn_by[item]
            ranks[stratum] += 1
        return sorted(rounds, key=lambda item_id: rounds[item_id])

    def _add(self, person: str, item: str, label: str | None, seconds: float | None) -> None:
        """Write a label of a text and of all equal texts in the sample; None withdraws the label."""
        labels = self._known(person)
        for same in (*(equal for equal in self._same[item] if equal != item), item):
            self._folder.add(person, Entry(item=same, label=label, seconds=seconds))
            labels.pop(same, None)
            if label is not None:
                labels[same] = label

    def _known(self, person: str) -> dict[str, str]:
        if person not in self._labels:
            self._labels[person] = self._folder.labels_by(person)
        return self._labels[person]

    def _count(self, person: str) -> int:
        return sum(item in self._drawn for item in self._labels[person])

    def _shown(self, drawn: SampledText) -> ShownText:
        options = (*self._label.options(drawn.context), UNCLEAR)
        is_known = self._label.choices == (YES, "no")
        keys = [_LETTERS[option] if option == UNCLEAR or is_known else str(n) for n, option in enumerate(options, 1)]
        question, *guidance = self._label.asked(drawn.context)
        heard = str(drawn.context.get("told", "")) if "$told" not in self._label.question else ""
        return ShownText(
            item=drawn.item,
            text=drawn.text,
            question=question,
            guidance=tuple(guidance),
            told=heard,
            choices=tuple(zip(keys, options, strict=True)),
        )
