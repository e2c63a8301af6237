"""Work that a test gives to a worker's process."""

import signal
import sys

from foundry.errors import FoundryError
from foundry.running.lane import LaneSpec


def echoing(spec: LaneSpec) -> str | None:
    sys.stdout.write("printed on the way\n")
    is_blocked = signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    return f"{spec.name}, SIGINT {'blocked' if is_blocked else 'open'}"


def failing(spec: LaneSpec) -> str | None:
    raise FoundryError(f"no luck with {spec.name}")


def waiting(spec: LaneSpec) -> str | None:
    signal.pause()
    return None
