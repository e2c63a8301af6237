"""The versions of software, and the commit of foundry, with which a record was made."""

import importlib.metadata
import platform
import subprocess
from functools import lru_cache

from foundry.paths import PACKAGE
from foundry.version import __version__

MENDING = "json-repair"
"""The package that repairs broken replies."""

PACKAGES = ("numpy", "scipy", "jinja2", "msgspec", "matplotlib", MENDING)
"""Packages whose version may affect a record or a frame."""

READERS = 4
"""Version of the code that reads replies; increase it if the code of any world reads any reply differently."""


@lru_cache(maxsize=1)
def versions() -> dict[str, str]:
    """Return the versions of foundry, Python and the packages that can change a record."""
    ours = {"foundry": __version__, "python": platform.python_version()}
    return ours | {name: importlib.metadata.version(name) for name in PACKAGES}


@lru_cache(maxsize=1)
def git_commit() -> str | None:
    """Return the commit of foundry's clone, marked `-dirty` if files have changed; None outside a clone."""
    if not (PACKAGE.parent / ".git").exists():
        return None
    command = ["git", "-C", str(PACKAGE.parent), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None
