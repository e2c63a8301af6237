"""A probe on the page: its moments with what was chosen in them, each in full when it is looked at."""

from __future__ import annotations

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
"""An export draws states of worlds for no longer than this, seconds; what agents were shown is always there."""
_ENCODE = msgspec.json.Encoder().encode


class ProbeView:
    """One probe; may be asked from several threads.

    Args:
        folder: the probe.
        trusted: further packages whose classes its world may be built of, where moments are made again.
    """

    def __init__(self, folder: SweepFolder, trusted: Sequence[str] = ()) -> None:
        self._probe = SeenProbe(folder, trusted)
        self._lock = threading.Lock()

    def get(self, what: str, numbers: Sequence[int]) -> Resource:
        """Return what an address below the probe stands for; see `foundry/viewer/README.md` for the keys.

        Raises:
            InputError: nothing.
            RecordError: the records it is made of cannot be read.
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
            InputError: there is none of this number.
            RecordError: the moments cannot be read.
        """
        moment = self._probe.moment(number)
        return moment.run, moment.step, moment.agent

    def exports(self) -> Iterator[tuple[str, Resource]]:
        """Yield all that can be asked, by address below the probe; states of worlds as far as that is no long work."""
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
    """Return a moment with the script that draws what was perceived in worlds of its form, if there is one."""
    return Resource(_ENCODE({**msgspec.structs.asdict(seen), "script": _script(seen.form)}))


def _script(form: str) -> str | None:
    return f"{form}/probe.js" if form and static_file(f"{form}/probe.js") else None
