"""Shows a sweep while it runs. The server is a process of its own, so that it never slows the sweep."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from foundry import own_code
from foundry.errors import InputError

LINGER_S = 1.0
"""Seconds for which the server still runs after the sweep, so that an open page can show the final state."""


@contextmanager
def serve_live(folder: Path, trusted: Sequence[str] = ()) -> Iterator[str]:
    """Show a sweep's folder on a page while the `with` block runs; another process serves it. Yield its address."""
    command = [sys.executable, "-m", "foundry.viewer.live", str(folder), *trusted]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdin is not None and process.stdout is not None
    try:
        url = process.stdout.readline().strip()
        if not url:
            raise InputError("The page of view=live cannot start. Run without view=live, and use foundry view.")
        yield url
    finally:
        process.stdin.close()
        process.wait()
        process.stdout.close()


def main(folder: str, *trusted: str) -> None:
    """Serve until standard input ends, which happens when the parent process ends."""
    from foundry.viewer.server import serving

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(10)
    own_code.use(())  # makes the user's code known, as in the parent process
    with serving(Path(folder), trusted=trusted) as server:
        sys.stdout.write(f"{server.url}\n")
        sys.stdout.flush()
        sys.stdin.read()
        if time.monotonic() - server.last_asked < LINGER_S:
            time.sleep(LINGER_S)


if __name__ == "__main__":
    main(*sys.argv[1:])
