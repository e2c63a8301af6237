"""Finds out whether there is a display to open a window on."""

from __future__ import annotations

import ctypes
import os
import sys

from foundry.errors import InputError


def check_display() -> None:
    """Find out whether there is a display, since VTK takes the process down where there is none.

    Raises:
        InputError: there is none.
    """
    if not sys.platform.startswith("linux"):
        return
    name = os.environ.get("DISPLAY", "")
    if not (name and _opens(name)):
        said = f"DISPLAY={name} cannot be opened" if name else "DISPLAY is not set"
        raise InputError(f"--window needs a display, and {said}: use --video or --out, which need none.")


def _opens(name: str) -> bool:
    try:
        library = ctypes.CDLL("libX11.so.6")
    except OSError:
        return False
    library.XOpenDisplay.restype = ctypes.c_void_p
    library.XOpenDisplay.argtypes = [ctypes.c_char_p]
    library.XCloseDisplay.argtypes = [ctypes.c_void_p]
    opened = library.XOpenDisplay(name.encode())
    if opened:
        library.XCloseDisplay(opened)
    return bool(opened)
