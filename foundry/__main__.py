"""`python -m foundry` and the command `foundry` begin here."""

from __future__ import annotations

import os
import sys


def main() -> None:
    """Run the command line and exit; the user may interrupt it while it is still being loaded."""
    try:
        from foundry import own_code

        own_code.working_directory_last()
        from foundry.running.cores import seek_garbage_seldom

        seek_garbage_seldom()
        from foundry import cli
    except KeyboardInterrupt:
        sys.stderr.write("foundry: interrupted\n")
        os._exit(130)  # Python itself ends by the signal where that came in a text run by `exec`, as in dataclasses
    cli.main()


if __name__ == "__main__":
    main()
