"""Finds a device that draws without a screen, and checks that VTK can draw on it."""

import ctypes
import ctypes.util
import os
import platform
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from typing import Any

import msgspec

from foundry.errors import InputError, not_found

INDEX = "VTK_EGL_DEVICE_INDEX"
"""Environment variable that tells VTK which device to use, by its index in EGL's list of devices."""
WANTED = "FOUNDRY_RENDERER"
"""Environment variable with the renderer that the user chooses, one of `Wish`."""

_EXTENSIONS, _MOST = 0x3055, 64
_SOFTWARE_DEVICE = b"EGL_MESA_device_software"
_SOFTWARE_NAMES = ("llvmpipe", "softpipe", "swrast", "swr (", "SwiftShader")


class Wish(StrEnum):
    """The renderers that a user can choose."""

    AUTO = "auto"  # a GPU that works, else software
    SOFTWARE = "software"  # the same pixels on every machine
    GPU = "gpu"  # a GPU, else an error


def egl_devices() -> list[bool]:
    """Return, for each device in EGL's list, whether it is a GPU; empty if EGL is missing or cannot list devices.

    A GPU may still be unusable. Source: EGL_EXT_device_enumeration, EGL_EXT_device_query.
    """
    name = ctypes.util.find_library("EGL") or "libEGL.so.1"
    try:
        egl: Any = ctypes.CDLL(name)
        find = egl.eglGetProcAddress
    except (OSError, AttributeError):
        return []
    find.restype, find.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
    query, tell = find(b"eglQueryDevicesEXT"), find(b"eglQueryDeviceStringEXT")
    if not query or not tell:
        return []
    listed, count = (ctypes.c_void_p * _MOST)(), ctypes.c_int32()
    ask = ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p)(query)
    if not ask(_MOST, listed, ctypes.byref(count)):
        return []
    about = ctypes.CFUNCTYPE(ctypes.c_char_p, ctypes.c_void_p, ctypes.c_int32)(tell)
    return [_SOFTWARE_DEVICE not in (about(device, _EXTENSIONS) or b"").split() for device in listed[: count.value]]


def wish() -> Wish:
    """Return the user's choice from the environment.

    Raises:
        InputError: the value is unknown.
    """
    asked = os.environ.get(WANTED) or Wish.AUTO
    if asked not in set(Wish):
        raise not_found(f"{WANTED}", asked, list(Wish), f"{WANTED} selects the renderer of 3D scenes.")
    return Wish(asked)


def places_to_try(asked: Wish, devices: Sequence[bool]) -> list[int | None]:
    """Return the indices of the devices to try, the best first, given whether each is a GPU; None lets VTK choose.

    Software rendering comes last. If VTK alone would prefer a GPU, the software device is given by its index.

    Raises:
        InputError: the choice is a GPU, but there is none.
    """
    gpus = [index for index, is_gpu in enumerate(devices) if is_gpu]
    software = [index for index, is_gpu in enumerate(devices) if not is_gpu]
    if asked == Wish.GPU:
        if not gpus:
            raise InputError(f"{WANTED}=gpu, but EGL lists no GPU here ({listing(devices)}). Install its EGL driver.")
        return list(gpus)
    last = software[0] if gpus and software else None
    return [last] if asked == Wish.SOFTWARE else [*gpus, last]


def listing(devices: Sequence[bool]) -> str:
    """Return the numbers of GPUs and software devices in words, given whether each device is a GPU."""
    return f"{sum(devices)} GPUs and {len(devices) - sum(devices)} software devices"


def is_software(renderer: str) -> bool:
    """Return whether a renderer draws in software, by its name in OpenGL."""
    return renderer.startswith(_SOFTWARE_NAMES)


_WINDOW, _HEADLESS = "VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow"
_PASSED = "_FOUNDRY_RENDERING_WORKS"
"""Environment variable that names a renderer that works, so that child processes do not test renderers again."""

_PROBE = """
from foundry.worlds.camera.eye.rendering import Canvas
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
    """Make VTK draw off screen through EGL if there is no screen or the environment selects a renderer.

    Call this function before you make a window.
    """
    has_screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and (not has_screen or wish() != Wish.AUTO):
        os.environ.setdefault(_WINDOW, _HEADLESS)


@dataclass(frozen=True)
class Drawer:
    """The renderer of this machine.

    Attributes:
        name: name and version of the OpenGL renderer.
        why: reason for the choice of the device.
    """

    name: str
    why: str


@cache
def check_rendering() -> Drawer:
    """Draw a test picture in another process, since VTK aborts a process if a library is missing; return the renderer.

    A GPU in EGL's list is preferred over software; `FOUNDRY_RENDERER` overrides this. The renderer is stored in the
    environment, so that child processes use it too.

    Raises:
        InputError: nothing can draw (the error names the package to install), or the user's choice is missing.
    """
    passed = os.environ.get(_PASSED)
    if passed:
        return msgspec.json.decode(passed, type=Drawer)
    choose_window()
    drawer = (
        _on_device() if os.environ.get(_WINDOW) == _HEADLESS and INDEX not in os.environ else _probed("VTK chose it")
    )
    os.environ[_PASSED] = msgspec.json.encode(drawer).decode()
    return drawer


def _on_device() -> Drawer:
    """Return the first working device of EGL's list, and select it for VTK."""
    asked, devices, failed = wish(), egl_devices(), ""
    *gpus, last = places_to_try(asked, devices)
    for index in gpus:
        try:
            drawer = _probed(f"a GPU, device {index} of EGL", index)
        except InputError as error:
            failed = failed or f"; device {index} did not draw: {error}"
            continue
        if not is_software(drawer.name):
            os.environ[INDEX] = str(index)
            return drawer
        failed = failed or f"; device {index} is not a GPU that can draw, but {drawer.name}"
    why = f"{WANTED}={asked}" if asked != Wish.AUTO else f"EGL lists {listing(devices)}{failed}"
    drawer = _probed(why, last)
    if asked != Wish.AUTO and is_software(drawer.name) != (asked == Wish.SOFTWARE):
        raise InputError(f"{WANTED}={asked}, but {drawer.name} draws here. Install the driver, or unset {WANTED}.")
    if last is not None:
        os.environ[INDEX] = str(last)
    return drawer


def _probed(why: str, index: int | None = None) -> Drawer:
    """Return the renderer that draws a picture on this device, or on the device that VTK chooses."""
    command = [sys.executable, "-c", _PROBE]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    if index is not None:
        environment[INDEX] = str(index)
    try:
        probe = subprocess.run(
            command, capture_output=True, text=True, timeout=_PATIENCE_S, check=False, env=environment
        )
    except subprocess.TimeoutExpired as error:
        raise InputError(f"Drawing a small picture took more than {_PATIENCE_S} s. {install_line()}") from error
    if probe.returncode != 0:
        raise InputError(f"This machine cannot draw 3D scenes without a screen ({_cause(probe)}). {install_line()}")
    return Drawer(probe.stdout.strip(), why)


def _cause(probe: subprocess.CompletedProcess[str]) -> str:
    if probe.returncode < 0:
        return f"VTK found no OpenGL, and signal {-probe.returncode} ended the test of VTK"
    return (probe.stderr.strip().splitlines() or [f"a test of VTK ended with code {probe.returncode}"])[-1]


def install_line() -> str:
    """Return the install instruction for this machine."""
    if not sys.platform.startswith("linux"):
        return "Install the graphics driver of this machine, or run on Linux with Mesa."
    try:
        system = platform.freedesktop_os_release()
    except OSError:
        system = {}
    names = f"{system.get('ID', '')} {system.get('ID_LIKE', '')}".split()
    for families, command in _PACKAGES:
        if any(name in families for name in names):
            return f"Install the system libraries that VTK needs: {command}"
    return "Install Mesa's EGL and its software driver (Debian: libegl1 and libgl1-mesa-dri)."
