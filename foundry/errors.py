"""Every error that foundry raises on purpose.

FoundryError
├── InputError            the user's request cannot be done; one clear line, exit code 2
│   ├── NotInstalledError     a package is missing that installs with one command
│   └── HostsDifferError      servers that should be equal have different models under the same name
├── RecordError           a recorded file is missing, damaged or of another version
├── StorageError          a file of a sweep or the answer cache cannot be written or read; ends the sweep
└── BackendError          a model's server did not give an answer
    ├── TransientError    worth another try; when the tries are used up, it ends the run
    ├── RequestError      the server refused this request; never tried again, ends the run
    ├── UnconfirmedError  it is unknown whether the server still has the weights that gave answers; ends the run
    └── ServerError       no request to this server can succeed; ends the sweep
        └── ModelChangedError   the server has other weights under the same name now
"""

import difflib
from collections.abc import Iterable

MOST_BESIDE_CLOSE = 10
"""Maximum number of names in the message about an unknown name that is close to one of them."""
MOST_NAMES = 40
"""Maximum number of names in the message about an unknown name that is close to none of them."""


class FoundryError(Exception):
    """Base class of all errors that foundry raises on purpose.

    Attributes:
        advice: the end of the message that says what to do, if it was given separately; else "".
    """

    def __init__(self, message: object = "", *, advice: str = "") -> None:
        super().__init__(f"{message} {advice}" if advice else message)
        self.advice = advice

    @property
    def problem(self) -> str:
        """The message without the advice."""
        return str(self).removesuffix(self.advice).rstrip()


class InputError(FoundryError):
    """The user's request cannot be done; the message says how to continue."""


class HostsDifferError(InputError):
    """Servers that should be equal have different models under the same name."""


class NotInstalledError(InputError):
    """A package is missing; `install` is the command that installs it."""

    def __init__(self, message: str, install: str) -> None:
        super().__init__(f"{message} {install}")
        self.install = install


class RecordError(FoundryError):
    """A recorded file is missing, damaged or of another version."""


class StorageError(FoundryError):
    """A file of a sweep or the answer cache cannot be written or read; no run can continue, so the sweep ends."""


class Interrupted(Exception):
    """The user asked to stop early; this is not an error, and nothing failed."""


class UndeclaredError(FoundryError):
    """A world wrote a record that it did not declare, so the run ends."""


class BackendError(FoundryError):
    """A model's server did not give an answer."""


class TransientError(BackendError):
    """A failed call that may succeed if foundry repeats it.

    Attributes:
        busy: whether the server is overloaded (503, 429).
        late: whether the server exceeded its time limit.
        retry_after_s: wait that the server requests, seconds; None if it requests none.
    """

    def __init__(
        self,
        message: str,
        *,
        busy: bool = False,
        late: bool = False,
        retry_after_s: float | None = None,
        advice: str = "",
    ) -> None:
        super().__init__(message, advice=advice)
        self.busy = busy
        self.late = late
        self.retry_after_s = retry_after_s


class RequestError(BackendError):
    """The server refused a request and would refuse it again, so the run ends."""


class UnconfirmedError(BackendError):
    """Nobody knows whether the server still has the weights that answered in a run, so the run ends."""


class ServerError(BackendError):
    """A server fails in a way that would make every request fail, so the sweep ends."""


class ModelChangedError(ServerError):
    """A server has other weights under a model's name than at the start of the sweep.

    Attributes:
        how: the change, in words.
        keys: keys of the answers that were used but may come from the other weights.
        removed: number of answers that were deleted from the cache.
    """

    def __init__(self, message: str, how: str, keys: Iterable[str], removed: int) -> None:
        super().__init__(message)
        self.how = how
        self.keys = frozenset(keys)
        self.removed = removed


def not_found(what: str, asked: str, available: Iterable[str], hint: str = "") -> InputError:
    """Return the error for a name that does not exist, with the closest name and the names that exist.

    Of many names, it gives the number and the most similar ones; it gives more of them if none is close.
    """
    names = sorted(set(available))
    close = difflib.get_close_matches(asked, names, n=1, cutoff=0.5)
    most = MOST_BESIDE_CLOSE if close else MOST_NAMES
    shown = names if len(names) <= most else sorted(difflib.get_close_matches(asked, names, n=most, cutoff=0.0))
    parts = [f"{what} '{asked}' not found."]
    if close:
        parts.append(f"Did you mean '{close[0]}'?")
    more = f" and {len(names) - len(shown)} more" if len(shown) < len(names) else ""
    parts.append(f"Available: {', '.join(shown)}{more}." if names else "None is available.")
    return InputError(" ".join(parts), advice=hint)
