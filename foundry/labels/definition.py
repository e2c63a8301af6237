"""Reads labels from YAML. A label is a question about texts, with its possible answers and a rule that answers it."""

import hashlib
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from string import Template
from typing import Any, Literal

import msgspec

from foundry.errors import InputError, not_found
from foundry.naming import target_of
from foundry.own_code import own_folders, refuse_shipped_name
from foundry.texts import one_line

Unit = Literal["message", "decision", "reply", "moment"]
"""The texts to which a label applies: messages, replies with a decision, replies in 3D worlds, replies in a probe."""
Context = Mapping[str, Any]
"""Facts about a text by name, such as the fires of the world, the agent's prompt, and the possible actions."""
Rule = Callable[[str, Context], str | None]
"""A function that returns the choice for a text, or None if the text does not show which choice is right."""

YES, NO = "yes", "no"
UNCLEAR = "unclear"
"""The answer of a labeller who cannot decide; no label may have a choice with this name."""
NONE = "none"
"""The choice for a reply that chooses no action, for a label whose choices are the actions of the world."""
ACTIONS = "actions"
"""With `choices: actions`, the choices for a reply are the actions that the world declares for its question."""

_SHIPPED = Path(__file__).parent / "shipped"
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")


class _Target(msgspec.Struct, frozen=True, rename={"target": "_target_"}):
    target: str


class _File(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    question: str
    choices: tuple[str | bool, ...] | Literal["actions"] = (YES, NO)
    unit: Unit = "message"
    rule: str | _Target | None = None
    near: str | _Target | None = None
    judge: str = ""


class Label(msgspec.Struct, frozen=True, kw_only=True):
    """A question about texts.

    Attributes:
        name: name of the file without `.yaml`.
        question: the question to a person; `$name` stands for a fact of the context, such as `$fires`.
        choices: possible answers; empty if they are the world's actions.
        rule: a regular expression (a match means the first choice), or the full name of a function; "" for none.
        rule_is_pattern: whether the rule is a regular expression.
        near: regular expression or function that matches texts for which the rule may be wrong; people label more of
            them.
        near_is_pattern: whether `near` is a regular expression.
        judge: the prompt to a model, with `$text`; by default it is made from the question.
    """

    name: str
    question: str
    choices: tuple[str, ...]
    unit: Unit
    rule: str = ""
    rule_is_pattern: bool = False
    near: str = ""
    near_is_pattern: bool = False
    judge: str = ""

    @property
    def question_sha256(self) -> str:
        """Hash of the question, the choices and the prompt for a model."""
        return hashlib.sha256(msgspec.json.encode((self.question, self.choices, self.judge))).hexdigest()

    def asked(self, context: Context) -> tuple[str, ...]:
        """Return the label's question to a person, line by line; its first line with a question mark comes first."""
        lines = [line for line in self.question.splitlines() if line.strip()]
        asking = next((line for line in lines if "?" in line), lines[0])
        return tuple(_filled(line, context) for line in (asking, *(line for line in lines if line is not asking)))

    def judged(self, text: str, context: Context) -> str:
        """Return the prompt that asks a model to label a text."""
        return _filled(self.judge, {**context, "text": text, "options": self.options(context)})

    def options(self, context: Context) -> tuple[str, ...]:
        """Return the answers that a labeller can choose for a text, apart from `UNCLEAR`."""
        return self.choices or (*context.get("actions", ()), NONE)

    def rule_function(self) -> Rule | None:
        """Return the function of the label's rule, or None if the label has no rule.

        Raises:
            InputError: the named function does not exist.
        """
        if not self.rule_is_pattern:
            return _function(self, "rule", self.rule) if self.rule else None
        pattern, (first, second, *_) = re.compile(self.rule), self.choices
        return lambda text, _: first if pattern.search(text) else second

    def near_function(self) -> Callable[[str, Context], bool]:
        """Return the function that says whether the rule may be wrong about a text."""
        if self.near_is_pattern:
            pattern = re.compile(self.near)
            return lambda text, _: pattern.search(text) is not None
        function: Callable[[str, Context], bool] = _function(self, "near", self.near) if self.near else lambda *_: False
        return function


def _function(label: Label, key: str, target: str) -> Any:
    try:
        return target_of(target)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(
            f"Label '{label.name}': the {key} is the function '{target}', which cannot be imported ({error}). Name a "
            "function in your own folder, such as rules.is_polite, and give the folder with --config-dir."
        ) from error


def _filled(template: str, context: Context) -> str:
    texts = {key: ", ".join(value) or "none" if isinstance(value, tuple) else value for key, value in context.items()}
    return Template(template).safe_substitute(texts)


def label_files() -> dict[str, Path]:
    """Return the file of each label by name: the shipped labels, then those in `labels/` of the user's folders.

    Raises:
        InputError: a label of the user has the name of a shipped label.
    """
    files = {file.stem: file for file in sorted(_SHIPPED.glob("*.yaml"))}
    shipped = dict(files)
    for file in (file for folder in own_folders() for file in sorted((folder / "labels").glob("*.yaml"))):
        refuse_shipped_name(f"{file.parent.parent.name}/labels/{file.name}", file.stem, shipped)
        files[file.stem] = file
    return files


def label_named(name: str) -> Label:
    """Return the label with the given name.

    Raises:
        InputError: the label does not exist, or its file cannot be used.
    """
    files = label_files()
    if name not in files:
        raise not_found("Label", name, files, "Put your own labels into labels/ of the folder given with --config-dir.")
    return read_label(files[name])


def read_label(file: Path) -> Label:
    """Return the label in a file.

    Raises:
        InputError: the file cannot be read, or does not define a label.
    """
    where = f"{file.parent.name}/{file.name}"
    if not _NAME.fullmatch(file.stem):
        raise InputError(f"{where}: '{file.stem}' is not a valid name for a label. Use at most 40 of a-z, 0-9 and _.")
    try:
        known = msgspec.yaml.decode(file.read_bytes(), type=_File)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(
            f"{where} is not a label: {one_line(error)}. A label needs a question; see docs/people.md."
        ) from error
    choices = () if known.choices == ACTIONS else tuple(_text(choice) for choice in known.choices)
    _check(where, choices, known)
    rule, near = (
        pattern.target if isinstance(pattern, _Target) else pattern or "" for pattern in (known.rule, known.near)
    )
    return Label(
        name=file.stem,
        question=known.question.strip(),
        choices=choices,
        unit=known.unit,
        rule=rule,
        rule_is_pattern=isinstance(known.rule, str),
        near=near,
        near_is_pattern=isinstance(known.near, str),
        judge=known.judge or _judge(known.question.strip(), choices),
    )


def _text(choice: str | bool) -> str:
    """Return a choice as text; YAML reads an unquoted yes as a boolean."""
    return choice if isinstance(choice, str) else (YES if choice else NO)


def _judge(question: str, choices: Sequence[str]) -> str:
    answers = " or ".join(choices) if choices else "$options"
    return f"Text between the lines:\n-----\n$text\n-----\n\n{question}\n\nAnswer with one word: {answers}.\n"


def _check(where: str, choices: Sequence[Any], known: _File) -> None:
    """Reject an empty question, unusable choices, and patterns that are no regular expressions."""
    if not known.question.strip():
        raise InputError(f"{where}: `question` is empty. Write the question that is asked about each text.")
    if known.choices != ACTIONS and (len(set(choices)) < 2 or len(set(choices)) < len(choices)):
        raise InputError(f"{where}: choices are {', '.join(choices) or 'missing'}. Use at least two different choices.")
    if UNCLEAR in choices or not all(isinstance(choice, str) and choice.strip() for choice in choices):
        raise InputError(f"{where}: a choice must be a non-empty text other than '{UNCLEAR}', which is always offered.")
    for key, pattern in (("rule", known.rule), ("near", known.near)):
        if isinstance(pattern, str):
            try:
                re.compile(pattern)
            except re.error as error:
                raise InputError(f"{where}: {key} is not a regular expression: {error}.") from error
    if isinstance(known.rule, str) and len(choices) != 2:
        raise InputError(
            f"{where}: a rule that is a regular expression needs exactly two choices, but there are {len(choices)}."
        )
