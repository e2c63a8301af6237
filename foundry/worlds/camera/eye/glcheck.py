"""Finds out, before VTK is asked to, whether this machine can draw without a screen, and with what."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from dataclasses import dataclass
from functools import cache

import msgspec

from foundry.errors import InputError
from foundry.worlds.camera.eye.devices import (
    INDEX,
    WANTED,
    Wish,
    egl_devices,
    is_software,
    listing,
    places_to_try,
    wish,
)

_WINDOW, _HEADLESS = "VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow"
_PASSED = "_FOUNDRY_RENDERING_WORKS"
"""Environment variable that tells the processes started from here what draws, so that they need not look again."""

_PROBE = """
from foundry.worlds.camera.eye.canvas import Canvas
print(Canvas(8, 8, samples=0).capabilities())
"""
_PATIENCE_S = 120
_PACKAGES = (
    (("debian", "ubuntu"), "sudo apt-get install libegl1 libgl1-mesa-dri"),
    (("fedora", "rhel", "centos"), "sudo dnf install mesa-libEGL mesa-dri-drivers"),
    (("suse", "opensuse"), "sudo zypper install Mesa-libEGL1 Mesa-dri"),
    (("arch",), "sudo pacman -S mesa"),
)


def choose_window() -> None:
    """Have VTK draw off screen through EGL where there is no screen, or the environment says what is to draw.

    To be called before a window is made.
    """
    has_screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and (not has_screen or wish() != Wish.AUTO):
        os.environ.setdefault(_WINDOW, _HEADLESS)


@dataclass(frozen=True)
class Drawer:
    """What draws on this machine.

    Attributes:
        name: of the OpenGL renderer, with its version.
        why: why it and no other.
    """

    name: str
    why: str


@cache
def check_rendering() -> Drawer:
    """Draw a picture in other processes, since VTK takes its own down where a library is missing; say what drew.

    A GPU that EGL lists draws where it can, else software; `FOUNDRY_RENDERER` says otherwise. What draws is kept in
    the environment, so that the processes started from here draw with the same.

    Raises:
        InputError: nothing can draw; names the package to install. Or what is asked for is not there.
    """
    passed = os.environ.get(_PASSED)
    if passed:
        return msgspec.json.decode(passed, type=Drawer)
    choose_window()
    found = (
        _on_device() if os.environ.get(_WINDOW) == _HEADLESS and INDEX not in os.environ else _probed("VTK chose it")
    )
    os.environ[_PASSED] = msgspec.json.encode(found).decode()
    return found


def _on_device() -> Drawer:
    """Return what draws of EGL's devices, and have VTK take it.

    Raises:
        InputError: none does.
    """
    asked, devices, failed = wish(), egl_devices(), ""
    *gpus, last = places_to_try(asked, devices)
    for index in gpus:
        try:
            found = _probed(f"a GPU, device {index} of EGL", index)
        except InputError as error:
            failed = failed or f"; device {index} did not draw: {error}"
            continue
        if not is_software(found.name):
            os.environ[INDEX] = str(index)
            return found
        failed = failed or f"; device {index} is no GPU that draws, but {found.name}"
    why = f"{WANTED}={asked}" if asked != Wish.AUTO else f"EGL lists {listing(devices)}{failed}"
    found = _probed(why, last)
    if asked != Wish.AUTO and is_software(found.name) != (asked == Wish.SOFTWARE):
        raise InputError(f"{WANTED}={asked}, but {found.name} draws here: install the driver, or leave {WANTED} out.")
    if last is not None:
        os.environ[INDEX] = str(last)
    return found


def _probed(why: str, index: int | None = None) -> Drawer:
    """Return what draws, on one device or on that which VTK takes.

    Raises:
        InputError: nothing does.
    """
    command = [sys.executable, "-c", _PROBE]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    if index is not None:
        environment[INDEX] = str(index)
    try:
        probe = subprocess.run(
            command, capture_output=True, text=True, timeout=_PATIENCE_S, check=False, env=environment
        )
    except subprocess.TimeoutExpired as error:
        raise InputError(f"Drawing one small picture took more than {_PATIENCE_S} s; {install_line()}") from error
    if probe.returncode != 0:
        raise InputError(f"This machine cannot draw 3D scenes without a screen ({_cause(probe)}). {install_line()}")
    return Drawer(probe.stdout.strip(), why)


def _cause(probe: subprocess.CompletedProcess[str]) -> str:
    if probe.returncode < 0:
        return f"VTK found no OpenGL and was ended by signal {-probe.returncode}"
    return (probe.stderr.strip().splitlines() or [f"the probe ended with code {probe.returncode}"])[-1]


def install_line() -> str:
    """Return what to install on this machine."""
    if not sys.platform.startswith("linux"):
        return "Install the graphics driver of this machine, or run on Linux with Mesa."
    try:
        system = platform.freedesktop_os_release()
    except OSError:
        system = {}
    names = f"{system.get('ID', '')} {system.get('ID_LIKE', '')}".split()
    for families, command in _PACKAGES:
        if any(name in families for name in names):
            return f"Install its system libraries: {command}"
    return "Install Mesa's EGL and its software driver (Debian: libegl1 and libgl1-mesa-dri)."
