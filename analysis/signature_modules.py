"""Finds the modules of signatures: the shipped ones and your own."""

import hashlib
import importlib
import inspect
import pkgutil
import tokenize
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from numbers import Real
from pathlib import Path
from types import ModuleType
from typing import Any

import foundry.labels
from analysis.any import label_signature
from analysis.any.any_run import AnyRun
from analysis.arrays import FloatArray
from analysis.form import analysis_in, shipped
from analysis.labelling.correcting import Correction
from analysis.measure import Measure
from foundry.errors import InputError
from foundry.labels.definition import label_files, read_label
from foundry.labels.items import MESSAGE
from foundry.own_code import OwnModule, own_modules, refuse_shipped_name
from foundry.texts import one_line

_SHIPPED_LABELS = Path(foundry.labels.__file__).parent
SHIPPED = "foundry"
"""The origin of the shipped modules."""


@dataclass(frozen=True, eq=False)
class Part:
    """One module of a signature.

    Attributes:
        run: the class of the runs that it measures.
        readable_too: whether it also has measures over readable decisions only.
        applies: returns whether it applies to the world of a run; this must not depend on what happened in the run.
        primary: whether it is tested by default.
        question: `message` if example moments of its findings are messages; "" if they are other decisions.
        module: full name of the module; for your own, the name of its file.
        label: label from which its measures are computed, or "".
        unlabelled: its measures that do not depend on the label.
        about: description of its measures, if its module has no docstrings.
        correct: returns a run's measures corrected by people's labels; None if they cannot be corrected.
    """

    name: str
    run: type
    function: Callable[[Any], Mapping[str, float]]
    measures: Mapping[str, Measure]
    headline: tuple[str, ...]
    readable_too: bool
    applies: Callable[[Any], bool]
    primary: bool
    question: str
    module: str
    origin: str
    file: Path
    label: str = ""
    unlabelled: tuple[str, ...] = ()
    about: str = ""
    correct: Callable[[Any, Correction], Mapping[str, FloatArray]] | None = None

    @cached_property
    def sha256(self) -> str:
        """Hash of the module's code; docstrings, comments and empty lines do not count."""
        content = code_lines(self.file).encode() if self.file.suffix == ".py" else self.file.read_bytes()
        return hashlib.sha256(content).hexdigest()

    def measure(self, run: Any) -> dict[str, float]:
        """Return the measures of a run over its counted decisions.

        Raises:
            InputError: a user's module fails on the run.
        """
        if self.origin == SHIPPED:
            return dict(self.function(run))
        try:
            return {name: _number(value) for name, value in self.function(run).items()}
        except Exception as error:  # the boundary: any error of a user's file is reported with its origin
            cause = one_line(f"{type(error).__name__}: {error}")
            raise InputError(f"{self.origin} cannot measure run {run.id}: {cause}") from error


def _always(_: Any) -> bool:
    return True


def _number(value: Any) -> float:
    if not isinstance(value, Real):
        raise TypeError(f"{value!r} is not a number")
    return float(value)


def parts() -> list[Part]:
    """Return all modules: the shipped ones, your own, and the modules of labels.

    Raises:
        InputError: a user's module cannot be used, or has the name of a shipped module or of another one for the same
            runs.
    """
    all_parts = [_part(module, SHIPPED) for module in _shipped()]
    for module in own_modules("signatures"):
        all_parts.append(_own_part(module))
        check_name(all_parts[-1].name, module.origin)
    all_parts += _of_labels({part.label for part in all_parts})
    taken: dict[tuple[str, type], Part] = {}
    known = _known_runs(all_parts)
    for part in all_parts:
        if part.run not in known:
            raise InputError(
                f"{part.origin}: the argument of measure() is annotated with {part.run.__name__}, which is not the "
                "class of runs of any form."
            )
        other = taken.setdefault((part.name, part.run), part)
        if other is not part:
            raise InputError(f"{part.origin} has the name '{part.name}', as {other.origin} has: rename one.")
    return all_parts


def check_name(name: str, origin: str) -> None:
    """Raise an InputError if a user's signature has the name of a shipped one."""
    refuse_shipped_name(origin, name, {module.NAME: module.__file__ for module in _shipped()})


def _known_runs(all_parts: Sequence[Part]) -> set[type]:
    """Return the classes of runs of all forms; further forms are imported only if a class is unknown."""
    known = {AnyRun, *(part.run for part in all_parts if part.origin == SHIPPED)}
    if all(part.run in known for part in all_parts):
        return known
    rooms = [file.parent.name for file in sorted(Path(__file__).parent.glob("*/*_run.py"))]
    forms = [*map(shipped, rooms), *(analysis_in(module) for module in own_modules("forms"))]
    return known | {form.run for form in forms if form is not None}


def _shipped() -> Iterator[ModuleType]:
    package = Path(__file__).parent
    for room in pkgutil.iter_modules([str(package)]):
        for module in pkgutil.iter_modules([str(package / room.name / "signatures")]):
            yield importlib.import_module(f"{__package__}.{room.name}.signatures.{module.name}")


def code_lines(file: Path) -> str:
    """Return the code of a Python file without docstrings, comments and empty lines, equal in every Python version."""
    with tokenize.open(file) as source:
        lines = source.read().split("\n")
    tokens = list(tokenize.generate_tokens(iter([f"{line}\n" for line in lines]).__next__))
    for token in tokens:
        if token.type == tokenize.COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column]
    code = [token for token in tokens if token.type not in (tokenize.COMMENT, tokenize.NL)]
    starts = (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)
    before = tokenize.NEWLINE
    for token, after in pairwise(code):
        if token.type == tokenize.STRING and before in starts and after.type == tokenize.NEWLINE:
            lines[token.start[0] - 1 : token.end[0]] = [""] * (token.end[0] - token.start[0] + 1)
        before = token.type
    return "\n".join(line.rstrip() for line in lines if line.strip())


def _own_part(own: OwnModule) -> Part:
    module = own.load()
    try:
        return _part(module, own.origin)
    except (AttributeError, NameError, TypeError) as error:
        raise InputError(
            f"{own.origin} is not a signature ({error}): it needs NAME, MEASURES, HEADLINE and a function "
            "measure(run: AnyRun), annotated with the class of runs that it measures."
        ) from error


def _part(module: ModuleType, origin: str) -> Part:
    return Part(
        name=module.NAME,
        run=_measured_class(module.measure),
        function=module.measure,
        measures=module.MEASURES,
        headline=tuple(module.HEADLINE),
        readable_too=getattr(module, "READABLE_TOO", True),
        applies=getattr(module, "applies", _always),
        primary=getattr(module, "PRIMARY", True),
        question=getattr(module, "QUESTION", ""),
        module=module.__name__ if origin == SHIPPED else Path(str(module.__file__)).name,
        origin=origin,
        file=Path(str(module.__file__)),
        label=getattr(module, "LABEL", ""),
        unlabelled=getattr(module, "UNLABELLED", ()),
        correct=getattr(module, "correct", None),
    )


def _of_labels(taken: Collection[str]) -> Iterator[Part]:
    for name, file in label_files().items():
        label = read_label(file) if name not in taken else None
        if label is not None and label.choices:
            measures = label_signature.measures_of(label)
            yield Part(
                name=name,
                run=AnyRun,
                function=partial(label_signature.measure, label=label),
                measures=measures,
                headline=tuple(measures)[:1],
                readable_too=True,
                applies=partial(label_signature.applies, label=label),
                primary=True,
                question=MESSAGE if label.unit == "message" else "",
                module=file.name,
                origin=SHIPPED if file.is_relative_to(_SHIPPED_LABELS) else f"labels/{file.name}",
                file=file,
                about=label_signature.about(label),
            )


def _measured_class(function: Callable[..., Any]) -> type:
    arguments = list(inspect.signature(function, eval_str=True).parameters.values())
    kind = arguments[0].annotation if len(arguments) == 1 else None
    if not isinstance(kind, type) or kind is inspect.Parameter.empty:
        raise TypeError("the argument of its function measure is not annotated")
    return kind
