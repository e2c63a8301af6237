"""A probe on the page: its moments with the choices, and the full content of a moment on request."""

import threading
import time
from collections.abc import Iterator, Sequence

import msgspec

from foundry.errors import InputError
from foundry.probing.seen import Seen, SeenProbe
from foundry.storing.store import SweepFolder
from foundry.viewer.files import static_file
from foundry.viewer.run_view import BINARY, Resource

EXPORTED_S = 60.0
"""Maximum time for drawing states of worlds in an export, seconds; images that agents saw are always exported."""
_ENCODE = msgspec.json.Encoder().encode


class ProbeView:
    """A probe; safe to use from several threads.

    Args:
        folder: the probe.
        trusted: further packages from which its world's classes may come, for rebuilding moments.
    """

    def __init__(self, folder: SweepFolder, trusted: Sequence[str] = ()) -> None:
        self._probe = SeenProbe(folder, trusted)
        self._lock = threading.Lock()

    def get(self, what: str, numbers: Sequence[int]) -> Resource:
        """Return the resource of an address below the probe; `foundry/viewer/README.md` lists the keys.

        Raises:
            InputError: there is no such resource.
            RecordError: the records cannot be read.
        """
        with self._lock:
            if what == "moments" and not numbers:
                return Resource(_ENCODE(self._probe.overview()))
            if what == "moment" and len(numbers) == 1:
                return _told(self._probe.seen(numbers[0]))
            if what == "picture" and len(numbers) == 3:
                return Resource(self._probe.picture(*numbers), BINARY)
        raise InputError(f"A probe has no '{what}' with {len(numbers)} numbers.")

    def place(self, number: int) -> tuple[str, int, int]:
        """Return run, step and agent of a moment.

        Raises:
            InputError: there is no moment with this number.
            RecordError: the moments cannot be read.
        """
        moment = self._probe.moment(number)
        return moment.run, moment.step, moment.agent

    def exports(self) -> Iterator[tuple[str, Resource]]:
        """Yield every resource by its address below the probe; states of worlds only if they are drawn quickly."""
        yield "moments", self.get("moments", ())
        begun = time.monotonic()
        for number in range(len(self._probe.moments.moments)):
            seen = self._probe.seen(number)
            yield f"moment/{number}", _told(seen)
            for one in seen.perceived:
                images = one.images or int(_script(seen.form) is None and time.monotonic() - begun < EXPORTED_S)
                for image in range(images):
                    yield f"picture/{number}/{one.edit}/{image}", self.get("picture", (number, one.edit, image))


def _told(seen: Seen) -> Resource:
    """Return a moment, and the script that draws perceptions in worlds of its form, if there is one."""
    return Resource(_ENCODE({**msgspec.structs.asdict(seen), "script": _script(seen.form)}))


def _script(form: str) -> str | None:
    return f"{form}/probe.js" if form and static_file(f"{form}/probe.js") else None
