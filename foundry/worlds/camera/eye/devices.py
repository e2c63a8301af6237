"""What EGL can draw on: which device is a GPU, and which one VTK is to take."""

from __future__ import annotations

import ctypes
import ctypes.util
import os
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from foundry.errors import InputError, not_found

INDEX = "VTK_EGL_DEVICE_INDEX"
"""Environment variable by which VTK is told the one device to draw on, by its place in EGL's list."""
WANTED = "FOUNDRY_RENDERER"
"""Environment variable of whoever would have it otherwise: one of `Wish`."""

_EXTENSIONS, _MOST = 0x3055, 64
_SOFTWARE_DEVICE = "EGL_MESA_device_software"
_SOFTWARE_NAMES = ("llvmpipe", "softpipe", "swrast", "swr (", "SwiftShader")


class Wish(StrEnum):
    """What is to draw."""

    AUTO = "auto"  # a GPU where one draws, else software
    SOFTWARE = "software"  # the same pixels on every machine
    GPU = "gpu"  # or nothing


@dataclass(frozen=True)
class Device:
    """One device of EGL.

    Attributes:
        index: its place in EGL's list.
        extensions: what EGL says of it.
    """

    index: int
    extensions: frozenset[str]

    @property
    def is_gpu(self) -> bool:
        """Whether it is hardware; it may still not let anybody draw."""
        return _SOFTWARE_DEVICE not in self.extensions


def devices_of(texts: Sequence[str]) -> tuple[Device, ...]:
    """Return the devices that EGL lists, by what it says of each."""
    return tuple(Device(index, frozenset(text.split())) for index, text in enumerate(texts))


def egl_devices() -> tuple[Device, ...]:
    """Return the devices of this machine; none where EGL is missing or cannot list them.

    Source: EGL_EXT_device_enumeration, EGL_EXT_device_query.
    """
    name = ctypes.util.find_library("EGL") or "libEGL.so.1"
    try:
        egl: Any = ctypes.CDLL(name)
        find = egl.eglGetProcAddress
    except (OSError, AttributeError):
        return ()
    find.restype, find.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
    query, tell = find(b"eglQueryDevicesEXT"), find(b"eglQueryDeviceStringEXT")
    if not query or not tell:
        return ()
    listed, count = (ctypes.c_void_p * _MOST)(), ctypes.c_int32()
    ask = ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p)(query)
    if not ask(_MOST, listed, ctypes.byref(count)):
        return ()
    about = ctypes.CFUNCTYPE(ctypes.c_char_p, ctypes.c_void_p, ctypes.c_int32)(tell)
    return devices_of([(about(one, _EXTENSIONS) or b"").decode("ascii", "replace") for one in listed[: count.value]])


def wish() -> Wish:
    """Return what the environment asks for.

    Raises:
        InputError: it is no such thing.
    """
    asked = os.environ.get(WANTED) or Wish.AUTO
    if asked not in set(Wish):
        raise not_found(f"{WANTED}", asked, list(Wish), f"{WANTED} says what draws 3D scenes.")
    return Wish(asked)


def places_to_try(asked: Wish, devices: Sequence[Device]) -> list[int | None]:
    """Return the devices to try by their index, the best first; None leaves the choice to VTK.

    Software is tried last, by its index where VTK would take a GPU first.

    Raises:
        InputError: a GPU is asked for, and there is none.
    """
    gpus = [one.index for one in devices if one.is_gpu]
    software = [one.index for one in devices if not one.is_gpu]
    if asked == Wish.GPU:
        if not gpus:
            raise InputError(f"{WANTED}=gpu, but EGL lists no GPU here ({listing(devices)}): install its EGL driver.")
        return list(gpus)
    last = software[0] if gpus and software else None
    return [last] if asked == Wish.SOFTWARE else [*gpus, last]


def listing(devices: Sequence[Device]) -> str:
    """Return how many devices there are, in words."""
    gpus = sum(one.is_gpu for one in devices)
    return f"{gpus} GPUs and {len(devices) - gpus} software devices"


def is_software(renderer: str) -> bool:
    """Return whether OpenGL's name of a renderer is one of software."""
    return renderer.startswith(_SOFTWARE_NAMES)
