"""The labels of a sweep in `labels/<label>/`: a file for the sample, one for each person, and one for each model.

Each label of a person becomes a line of the person's file. The line is on the disk before the page confirms the label,
and a later line about the same text replaces an earlier one. Because each person has a file, several people can label
at the same time; because each label is on the disk, a crash loses no label.
"""

import hashlib
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import msgspec

from foundry.errors import InputError, RecordError
from foundry.expansion import slug
from foundry.labels.definition import Label
from foundry.labels.sampling import Sample
from foundry.records import NOT_JSON
from foundry.storing.fresh import ensure_writable
from foundry.storing.plain import is_there, plain
from foundry.storing.run_files import json_file, write_atomically
from foundry.storing.store import SweepFolder

LABELS = "labels"
_PERSON = re.compile(r"\w[\w-]{0,39}")
_SAMPLE = "sample.json"
_BEGINS = b'{"item":'
"""Every line of a person's file begins with these bytes."""


class Entry(msgspec.Struct, frozen=True, kw_only=True):
    """A line of the file with one person's labels.

    Attributes:
        item: name of the text (`Item.id`).
        label: the answer; null if the person withdrew it.
        seconds: time between showing the text and the answer.
    """

    item: str
    label: str | None
    seconds: float | None = None


class Judgement(msgspec.Struct, frozen=True, kw_only=True):
    """A model's answer about one text; `label` is null if the reply is none of the choices."""

    text: str
    context: dict[str, str | tuple[str, ...]]
    label: str | None
    reply: str


class Judge(msgspec.Struct, frozen=True, kw_only=True):
    """A model's labels of all texts in a sweep (`labels/<label>/models/<model>.json`).

    Attributes:
        digest: the model's digest on its server, or null.
        parameters: the model's settings that affect the answers.
        judgements: one for each distinct text with its context.
        by_hand: answers about texts with known labels, which show how often the model is right.
    """

    labeller: str
    digest: str | None
    question_sha256: str
    parameters: dict[str, Any]
    judgements: tuple[Judgement, ...]
    by_hand: tuple[Judgement, ...] = ()


@dataclass(frozen=True)
class LabelFolder:
    """The files of one label of a sweep.

    Attributes:
        path: the folder; it exists as soon as texts are drawn or labelled.
    """

    path: Path
    label: str

    @classmethod
    def of(cls, sweep: SweepFolder, label: str) -> "LabelFolder":
        """Return the folder of a label of a sweep."""
        return cls(sweep.path / LABELS / label, label)

    def sample(self) -> Sample | None:
        """Return the texts that people label, or None if none were drawn.

        Raises:
            RecordError: the file cannot be read.
        """
        return json_file(self.path / _SAMPLE, Sample)

    def keep_sample(self, sample: Sample) -> None:
        """Store the sample."""
        self._keep(self.path / _SAMPLE, sample)

    def judges(self) -> list[Judge]:
        """Return the answers of all models, sorted by the names of their files."""
        judges = (json_file(file, Judge) for file in sorted(plain(self.path / "models").glob("*.json")))
        return [judge for judge in judges if judge is not None]

    def keep_judge(self, judge: Judge) -> Path:
        """Store the answers of a model in place of its earlier answers, and return the file."""
        short = hashlib.sha256(judge.labeller.encode()).hexdigest()[:6]
        file = self.path / "models" / f"{slug(judge.labeller)}-{short}.json"
        self._keep(file, judge)
        return file

    def people(self) -> list[str]:
        """Return the names of the people who labelled."""
        return sorted(file.stem for file in plain(self.path / "people").glob("*.jsonl"))

    def labels_by(self, person: str) -> dict[str, str]:
        """Return the label that a person gave each text, in the order of labelling.

        Raises:
            RecordError: a line cannot be read; the last line, which a crash may have cut, is ignored.
        """
        labels: dict[str, str] = {}
        for entry in self._entries(person):
            labels.pop(entry.item, None)
            if entry.label is not None:
                labels[entry.item] = entry.label
        return labels

    def add(self, person: str, entry: Entry) -> None:
        """Add a line to a person's file; when this returns, the line is on the disk.

        Raises:
            InputError: the name cannot be used, or the file cannot be written.
        """
        file, line = self._journal(person), msgspec.json.encode(entry) + b"\n"
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            with file.open("a+b") as lines:
                end = lines.seek(0, os.SEEK_END)
                lines.seek(max(0, end - 1))
                cut = end > 0 and lines.read() != b"\n"
                lines.write(b"\n" + line if cut else line)
                lines.flush()
                os.fsync(lines.fileno())
        except OSError as error:
            raise InputError(f"Cannot write the label into '{file}': {error}") from error

    def _entries(self, person: str) -> list[Entry]:
        file = self._journal(person)
        lines = file.read_bytes().split(b"\n") if is_there(file) else []
        entries = []
        for number, line in enumerate(lines, 1):
            try:
                entries += [msgspec.json.decode(line, type=Entry)] if line else []
            except NOT_JSON as error:
                # A line that a crash cut is left out; `add` then began a new line after it.
                if line.endswith(b"}") or not line.startswith(_BEGINS[: len(line)]):
                    raise RecordError(f"Line {number} of {file} cannot be read: {error}") from error
        return entries

    def _journal(self, person: str) -> Path:
        if not _PERSON.fullmatch(person):
            raise InputError(
                f"'{person}' is not a valid name for a person: use at most 40 letters, digits, - and _, such as p07."
            )
        return plain(self.path / "people" / f"{person}.jsonl")

    def _keep(self, file: Path, value: msgspec.Struct) -> None:
        ensure_writable(file.parent)
        write_atomically(file, msgspec.json.format(msgspec.json.encode(value), indent=1) + b"\n")


@dataclass(frozen=True)
class Labels:
    """The texts of a sample with the labels of people.

    Attributes:
        by_person: label by person and text.
    """

    sample: Sample
    by_person: Mapping[str, Mapping[str, str]]

    @classmethod
    def of(cls, sweep: SweepFolder, label: Label) -> "Labels | None":
        """Return people's labels of a sweep, or None if no sample was drawn for this label."""
        folder = LabelFolder.of(sweep, label.name)
        sample = folder.sample()
        if sample is None or sample.question_sha256 != label.question_sha256:
            return None
        return cls(sample, {person: folder.labels_by(person) for person in folder.people()})

    @cached_property
    def answers(self) -> dict[str, list[str]]:
        """For each text of the sample that people have labelled, the labels of these people."""
        by_item: dict[str, list[str]] = {}
        for drawn in self.sample.drawn:
            answers = [labels[drawn.item] for labels in self.by_person.values() if drawn.item in labels]
            if answers:
                by_item[drawn.item] = answers
        return by_item


def label_names(sweep: SweepFolder) -> list[str]:
    """Return the names of the labels for which a sweep has a sample or answers."""
    return sorted(entry.name for entry in plain(sweep.path / LABELS).glob("*") if entry.is_dir())


def label_files_of(sweep: SweepFolder) -> Sequence[Path]:
    """Return the files of all labels of a sweep, which belong into a bundle."""
    return sorted(file for file in plain(sweep.path / LABELS).rglob("*.json*") if plain(file).is_file())
