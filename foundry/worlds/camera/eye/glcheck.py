"""Finds out, before VTK is asked to, whether this machine can draw without a screen."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from functools import cache

from foundry.errors import InputError

_WINDOW, _HEADLESS = "VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow"
_PASSED = "_FOUNDRY_RENDERING_WORKS"
"""Environment variable that tells the processes started from here that they need not look again."""

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
    """Have VTK draw off screen through EGL where there is no screen; to be called before a window is made."""
    has_screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not has_screen:
        os.environ.setdefault(_WINDOW, _HEADLESS)


@cache
def check_rendering() -> None:
    """Draw a picture in another process, since VTK takes its own down where a library is missing.

    Raises:
        InputError: it cannot draw; names the package to install.
    """
    if os.environ.get(_PASSED):
        return
    command = [sys.executable, "-c", _PROBE]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    try:
        probe = subprocess.run(
            command, capture_output=True, text=True, timeout=_PATIENCE_S, check=False, env=environment
        )
    except subprocess.TimeoutExpired as error:
        raise InputError(f"Drawing one small picture took more than {_PATIENCE_S} s; {install_line()}") from error
    if probe.returncode != 0:
        raise InputError(f"This machine cannot draw 3D scenes without a screen ({_cause(probe)}). {install_line()}")
    os.environ[_PASSED] = "1"


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
