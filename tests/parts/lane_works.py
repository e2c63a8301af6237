"""What a worker's process can be given to do in a test."""

from __future__ import annotations

import os
import signal
import sys

from foundry.errors import FoundryError
from foundry.running.lane import LaneSpec


def echoing(spec: LaneSpec) -> str | None:
    sys.stdout.write("printed on the way\n")
    return spec.name


def failing(spec: LaneSpec) -> str | None:
    raise FoundryError(f"no luck with {spec.name}")


def dying(spec: LaneSpec) -> str | None:
    os.kill(os.getpid(), signal.SIGKILL)
    return None


def waiting(spec: LaneSpec) -> str | None:
    signal.pause()
    return None


def blocked(spec: LaneSpec) -> str | None:
    return "blocked" if signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []) else None
