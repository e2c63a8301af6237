"""`python -m foundry` and the command `foundry` begin here."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line and exit; the user may interrupt it while it is still being loaded."""
    try:
        from foundry import own_code

        own_code.working_directory_last()
        from foundry import cli
    except KeyboardInterrupt:
        sys.stderr.write("foundry: interrupted\n")
        sys.exit(130)
    cli.main()


if __name__ == "__main__":
    main()
