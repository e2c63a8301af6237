"""The entry point of `python -m foundry` and of the command `foundry`."""

import os
import signal


def main() -> None:
    """Run the command line and exit; if the user presses Ctrl-C while it loads, exit with one line."""
    is_heeded = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if is_heeded:
        signal.signal(signal.SIGINT, _end)
    from foundry import own_code

    own_code.working_directory_last()
    from foundry.running.cores import seek_garbage_seldom

    seek_garbage_seldom()
    from foundry import cli

    if is_heeded:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    cli.main()


def _end(*_: object) -> None:
    """Exit at once, without an exception: Python would lose one that is raised while it releases an import lock."""
    os.write(2, b"foundry: interrupted\n")
    os._exit(130)


if __name__ == "__main__":
    main()
