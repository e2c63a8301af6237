"""Makes and checks the folders of new sweeps."""

import contextlib
import datetime
import errno
import os
from pathlib import Path

from foundry.errors import InputError
from foundry.storing.plain import is_there

SWEEP_FILE = "sweep.yaml"
MULTIRUN_FILE = "multirun.yaml"
PREREGISTRATION_FILE = "preregistration.yaml"
_PROBE = ".probe."
"""Beginning of the names of files that foundry writes to test whether a folder is writable."""


def fresh_folder(root: Path) -> Path:
    """Create a new folder in `root` that is named by the present time, and return it."""
    stamp = datetime.datetime.now().strftime("%Y-%m-%d_%H-%M-%S")
    for suffix in ("", *(f"_{number}" for number in range(2, 1000))):
        candidate = root / (stamp + suffix)
        with contextlib.suppress(FileExistsError):
            candidate.mkdir(parents=True)
            return candidate
    raise InputError(f"No new folder could be made in '{root}'. Name one with output.dir=DIR.")


def is_sweep(path: Path) -> bool:
    """Return whether a folder holds a sweep."""
    return is_there(path / SWEEP_FILE)


def ensure_writable(path: Path) -> None:
    """Create a folder if it does not exist, and check that it is writable."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / f"{_PROBE}{os.getpid()}"
        probe.write_bytes(b"")
        probe.unlink()
    except ValueError as error:  # the path contains a null character
        raise InputError(f"'{path}' cannot be the name of a folder ({error}). Choose another.") from error
    except OSError as error:
        cause = errno.errorcode.get(error.errno or 0, "error")
        raise InputError(
            f"'{path}' cannot be written to ({cause}: {error.strerror}). Choose another folder."
        ) from error


def check_own(path: Path) -> None:
    """Reject the folder of a new sweep if it contains files that foundry did not write there."""
    own = (MULTIRUN_FILE, PREREGISTRATION_FILE, "locks")
    others = [entry.name for entry in path.iterdir() if entry.name not in own]
    begun = (_PROBE, f".{SWEEP_FILE}.", f".{MULTIRUN_FILE}.")
    if not all(name.startswith(begun) for name in others) and not is_sweep(path):
        raise InputError(f"output.dir='{path}' contains files that are not a sweep. Name an empty or a new folder.")
