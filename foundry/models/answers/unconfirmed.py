"""Which answers of a model count only until its server said once more that it has the same weights."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from foundry.errors import ModelChangedError
from foundry.models.answers.answers import Answers
from foundry.models.base import ModelInfo, Reply

Told: TypeAlias = Callable[[Reply], Mapping[str, str]]
WAYS_ON = (
    "Answers given since it was confirmed last have left the cache, and the runs that used them failed with this "
    "cause; all others stand. Put the first one back and go on with foundry resume, which asks for what is missing, "
    "or begin a new sweep in another output.dir."
)


def marks_of(info: ModelInfo) -> dict[str | None, str]:
    """Return what each server of a model is, by its base URL; None for any other, where no server is known.

    Equal marks are equal weights under the same name on the same server, not written anew in between.
    """
    if info.identity is None:
        return {}
    states: dict[str | None, str] = dict(info.states.items()) or {None: ""}
    return {host: " ".join((info.name, info.identity, host or "", state)) for host, state in states.items()}


@dataclass(frozen=True)
class Moment:
    """What was unconfirmed when a server was asked.

    Attributes:
        newest: number of the newest unconfirmed answer of all.
        used: keys of the unconfirmed answers that were used here.
    """

    newest: int
    used: frozenset[str]


class Unconfirmed:
    """The answers of one model in the cache, as far as they may be used.

    An answer is kept with a mark of what its server is. When the server was asked again and is the same, the marks of
    all answers that were there before it was asked are taken away, whoever got them; when it is another one, the marked
    answers leave the cache. So what a killed worker left behind is confirmed or removed by whoever uses it next. A
    marked answer of another server, or of one that was changed since, is as good as absent.

    Attributes:
        changed: why nothing more may be asked, once the server is another one.
    """

    def __init__(self, answers: Answers, info: ModelInfo | None = None, weights_of: Told = lambda reply: {}) -> None:
        """Take the cache and what is known of the model.

        Args:
            answers: the cache.
            info: what the server said when the sweep was checked; None where that cannot change.
            weights_of: reads what a reply itself says of the weights.
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
        """Whether an answer was used that waits for a confirmation."""
        return bool(self._used)

    def find(self, keys: Sequence[str]) -> dict[str, Reply]:
        """Return the answers that are there and may be used, by key."""
        answers = self._answers.find(keys)
        waiting = {key for key, kept in answers.items() if kept.mark is not None}
        if not waiting:
            return {key: kept.reply for key, kept in answers.items()}
        mine = {key for key in waiting if answers[key].mark in self._known}
        for key in mine:
            self.check(answers[key].reply)
        self._used |= mine
        return {key: kept.reply for key, kept in answers.items() if key in mine or key not in waiting}

    def check(self, reply: Reply | None = None) -> None:
        """Go on only while the server has the weights that it had, as far as is known and as a reply itself says."""
        if self.changed is not None:
            raise self.changed
        if reply is None:
            return
        for what, said in self._weights_of(reply).items():
            first = self._told.setdefault((reply.host, what), said)
            if said != first:
                raise self.change(f"its replies said {what} '{first}' first, and say '{said}' now")

    def keep(self, replies: Mapping[str, Reply], model: str) -> None:
        """Store replies in one transaction; they are committed when this returns."""
        self.check()
        marks = {key: self._mark(reply.host) for key, reply in replies.items()} if self._marks else {}
        self._answers.put(replies, model, marks)
        self._used |= marks.keys()

    def _mark(self, host: str | None) -> str:
        return self._marks[host] if host in self._marks else next(iter(self._marks.values()))

    def moment(self) -> Moment:
        """Return what is unconfirmed now; to be called before the server is asked."""
        return Moment(self._answers.newest(), frozenset(self._used))

    def settle(self, moment: Moment, info: ModelInfo) -> None:
        """Confirm what was unconfirmed at a moment, after which the server said this."""
        if marks_of(info) != self._marks:
            raise self.change(self._difference(info))
        self._answers.confirm(self._known, moment.newest)
        if moment.used and self._answers.removals(self._known) != self._removals:
            raise self.change("another process found other weights")
        self._used -= moment.used

    def change(self, how: str) -> ModelChangedError:
        """Remove what is unconfirmed and return the error that says why; the same one from then on."""
        if self.changed is None:
            removed = self._answers.remove(self._known)
            message = f"Model '{self._name}' changed while the sweep ran ({how}). {WAYS_ON}"
            self.changed = ModelChangedError(message, how, self._used, removed)
        return self.changed

    def _difference(self, info: ModelInfo) -> str:
        then, now = _digest(self._marks), _digest(marks_of(info))
        if then == now:
            return f"digest {now[:12]} as when it began, but written anew since"
        return f"digest {then[:12]} when it began, {now[:12]} now"


def _digest(marks: Mapping[str | None, str]) -> str:
    """Return the digest in marks, short enough to be shown."""
    return next(iter(marks.values()), "none none").split(" ")[1]
