"""Reads a probe for the page: its moments with the choices of models, and single moments in full."""

import threading
import time
from collections.abc import Iterator, Sequence

import msgspec

from foundry.errors import InputError
from foundry.probing.seen import SeenMoment, SeenProbe
from foundry.storing.store import SweepFolder
from foundry.texts import counted
from foundry.viewer.files import static_file
from foundry.viewer.run_view import BINARY, Resource

EXPORTED_S = 60.0
"""Maximum time for drawing pictures of worlds in an export, seconds. Images that agents saw need no drawing."""
_ENCODE = msgspec.json.Encoder().encode


class ProbeView:
    """Returns the data of a probe for its page; several threads may use it at once.

    Args:
        trusted: further packages that may contain classes of the probe's world.
    """

    def __init__(self, folder: SweepFolder, trusted: Sequence[str] = ()) -> None:
        self._probe = SeenProbe(folder, trusted)
        self._lock = threading.Lock()

    def get(self, what: str, numbers: Sequence[int]) -> Resource:
        """Return a resource of the probe, or raise InputError. `foundry/viewer/README.md` lists the addresses."""
        with self._lock:
            if what == "moments" and not numbers:
                return Resource(_ENCODE(self._probe.overview()))
            if what == "moment" and len(numbers) == 1:
                return _told(self._probe.seen(numbers[0]))
            if what == "picture" and len(numbers) == 3:
                return Resource(self._probe.picture(*numbers), BINARY)
        raise InputError(f"A probe has no data at an address with '{what}' and {counted(len(numbers), 'number')}.")

    def place(self, number: int) -> tuple[str, int, int]:
        """Return the run, the step and the agent of a moment, or raise InputError if there is no such moment."""
        moment = self._probe.moment(number)
        return moment.run, moment.step, moment.agent

    def exports(self) -> Iterator[tuple[str, Resource]]:
        """Yield the addresses and contents of all resources; pictures of worlds are drawn for `EXPORTED_S` seconds."""
        yield "moments", self.get("moments", ())
        begun = time.monotonic()
        for number in range(len(self._probe.moments.moments)):
            seen = self._probe.seen(number)
            yield f"moment/{number}", _told(seen)
            for perceived in seen.perceived:
                images = perceived.images or int(_script(seen.form) is None and time.monotonic() - begun < EXPORTED_S)
                for image in range(images):
                    yield (
                        f"picture/{number}/{perceived.edit}/{image}",
                        self.get("picture", (number, perceived.edit, image)),
                    )


def _told(seen: SeenMoment) -> Resource:
    """Return a moment, with the address of the script that draws its observation (None if its form has no script)."""
    return Resource(_ENCODE({**msgspec.structs.asdict(seen), "script": _script(seen.form)}))


def _script(form: str) -> str | None:
    return f"{form}/probe.js" if form and static_file(f"{form}/probe.js") else None
