"""Handles unconfirmed answers, which count only after a check found that their server has the same weights."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from foundry.errors import ModelChangedError
from foundry.models.answers.answers import Answers
from foundry.models.base import ModelInfo, Reply

WeightsOf: TypeAlias = Callable[[Reply], Mapping[str, str]]
WAYS_ON = (
    "Unconfirmed answers were removed from the cache, and their runs failed with this cause; all other answers stay. "
    "Restore the first model and continue with foundry resume, or begin a new sweep in another output.dir."
)


def marks_of(info: ModelInfo) -> dict[str | None, str]:
    """Return a mark (a hash of the state) of each server of a model, by base URL, or None without an address.

    If a server has the same mark twice, it had the same weights both times, and they were not replaced in between.
    """
    if info.identity is None:
        return {}
    states: dict[str | None, str] = dict(info.states.items()) or {None: ""}
    return {host: " ".join((info.name, info.identity, host or "", state)) for host, state in states.items()}


@dataclass(frozen=True)
class Moment:
    """The answers that were unconfirmed when a check of the server began.

    Attributes:
        newest: number of the newest unconfirmed answer in the cache.
        used: keys of the unconfirmed answers that this process used.
    """

    newest: int
    used: frozenset[str]


class Unconfirmed:
    """Finds and stores the cached answers of one model, and confirms or deletes its unconfirmed answers.

    An answer is stored with a mark, which identifies the state of its server. If a later check finds the server
    unchanged, the marks of all earlier answers are removed, for all processes. If the server has changed, the marked
    answers are deleted. If a worker is killed, the next user of the cache confirms or deletes its marked answers. A
    marked answer of another server, or of a server that has changed, counts as absent.

    Attributes:
        changed: the error that every further call raises once the server has changed; None before.
    """

    def __init__(
        self, answers: Answers, info: ModelInfo | None = None, weights_of: WeightsOf = lambda reply: {}
    ) -> None:
        """Take the cache and the facts about the model.

        Args:
            answers: the cache.
            info: what the server said about the model when the sweep started; None if this cannot change.
            weights_of: function that returns the facts in a reply that identify the weights.
        """
        self.changed: ModelChangedError | None = None
        self._answers = answers
        self._name = "" if info is None else info.name
        self._marks = {} if info is None else marks_of(info)
        self._known = frozenset(self._marks.values())
        self._used: set[str] = set()
        self._weights_of = weights_of
        self._told: dict[tuple[str | None, str], str] = {}
        self._removals = answers.removals(self._known) if self._known else 0

    @property
    def any_used(self) -> bool:
        """True if an answer was used that is not confirmed yet."""
        return bool(self._used)

    def find(self, keys: Sequence[str]) -> dict[str, Reply]:
        """Return, by key, the cached answers that are confirmed or wait for the next check of this server."""
        answers = self._answers.find(keys)
        waiting = {key for key, cached in answers.items() if cached.mark is not None}
        if not waiting:
            return {key: cached.reply for key, cached in answers.items()}
        mine = {key for key in waiting if answers[key].mark in self._known}
        for key in mine:
            self.check(answers[key].reply)
        self._used |= mine
        return {key: cached.reply for key, cached in answers.items() if key in mine or key not in waiting}

    def check(self, reply: Reply | None = None) -> None:
        """Raise an error if the server is known to have changed, or if a reply shows such a change."""
        if self.changed is not None:
            raise self.changed
        if reply is None:
            return
        for what, said in self._weights_of(reply).items():
            first = self._told.setdefault((reply.host, what), said)
            if said != first:
                raise self.change(f"its replies first reported {what} '{first}', and now report '{said}'")

    def keep(self, replies: Mapping[str, Reply], model: str) -> None:
        """Store replies in one transaction, committed on return."""
        self.check()
        marks = {key: self._mark(reply.host) for key, reply in replies.items()} if self._marks else {}
        self._answers.put(replies, model, marks)
        self._used |= marks.keys()

    def _mark(self, host: str | None) -> str:
        return self._marks[host] if host in self._marks else next(iter(self._marks.values()))

    def moment(self) -> Moment:
        """Return the answers that are unconfirmed now; call this method before a check of the server."""
        return Moment(self._answers.newest(), frozenset(self._used))

    def settle(self, moment: Moment, info: ModelInfo) -> None:
        """Confirm these answers if the server, checked after them, still reports the same facts."""
        if marks_of(info) != self._marks:
            raise self.change(self._difference(info))
        self._answers.confirm(self._known, moment.newest)
        if moment.used and self._answers.removals(self._known) != self._removals:
            raise self.change("another process found different weights")
        self._used -= moment.used

    def change(self, how: str) -> ModelChangedError:
        """Delete the unconfirmed answers, and return an error with the cause; later calls return this error again."""
        if self.changed is None:
            removed = self._answers.remove(self._known)
            message = f"Model '{self._name}' changed during the sweep ({how}). {WAYS_ON}"
            self.changed = ModelChangedError(message, how, self._used, removed)
        return self.changed

    def _difference(self, info: ModelInfo) -> str:
        then, now = _digest(self._marks), _digest(marks_of(info))
        if then == now:
            return f"digest {now[:12]} as at the start, but the model was installed again since"
        return f"digest {then[:12]} at the start, {now[:12]} now"


def _digest(marks: Mapping[str | None, str]) -> str:
    return next(iter(marks.values()), "none none").split(" ")[1]
