"""Which of EGL's devices draws; a machine that cannot draw is told so in one line, before VTK crashes."""

import os
import sys
from collections.abc import Iterator
from ctypes.util import find_library

import pytest

from foundry.errors import InputError
from foundry.worlds.camera.eye import devices as device_module
from foundry.worlds.camera.eye.devices import (
    INDEX,
    WANTED,
    Drawer,
    Wish,
    check_rendering,
    egl_devices,
    install_line,
    is_software,
    listing,
    places_to_try,
    wish,
)

NVIDIA, SOFTWARE = True, False
"""Whether a device of EGL is a GPU."""


@pytest.fixture
def unchecked(monkeypatch: pytest.MonkeyPatch) -> Iterator[pytest.MonkeyPatch]:
    """An environment without a screen in which nothing has been looked at yet."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY", WANTED, INDEX):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    monkeypatch.setenv("_FOUNDRY_RENDERING_WORKS", "")
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    check_rendering.cache_clear()
    yield monkeypatch
    check_rendering.cache_clear()


def test_gpus_come_first_and_software_by_its_place_behind_them_and_a_machine_without_one_is_left_as_it_is() -> None:
    both = [NVIDIA, SOFTWARE, NVIDIA]
    assert places_to_try(Wish.AUTO, both) == [0, 2, 1]
    assert places_to_try(Wish.SOFTWARE, both) == [1]
    assert places_to_try(Wish.GPU, both) == [0, 2]
    assert listing(both) == "2 GPUs and 1 software devices"
    assert places_to_try(Wish.AUTO, [SOFTWARE]) == [None] == places_to_try(Wish.AUTO, ())
    with pytest.raises(InputError, match="FOUNDRY_RENDERER=gpu, but EGL lists no GPU here"):
        places_to_try(Wish.GPU, [SOFTWARE])


def test_the_devices_of_this_machine_are_listed_and_names_of_software_are_told_from_those_of_hardware() -> None:
    assert {*egl_devices()} <= {NVIDIA, SOFTWARE}
    assert is_software("llvmpipe (LLVM 15.0.6, 256 bits), 4.5") and is_software("softpipe, 3.3")
    assert not is_software("NVIDIA H100 80GB HBM3/PCIe/SSE2, 4.6.0 NVIDIA 550.54")


def test_a_wish_that_is_none_is_refused(unchecked: pytest.MonkeyPatch) -> None:
    unchecked.setenv(WANTED, "softwar")
    with pytest.raises(InputError, match="FOUNDRY_RENDERER 'softwar' not found. Did you mean 'software'"):
        wish()


def drawn(unchecked: pytest.MonkeyPatch, names: dict[int | None, str], devices: list[bool]) -> Drawer:
    """Return who draws where processes that draw on a device (None: VTK's choice) are told these names."""

    def probed(why: str, index: int | None = None) -> Drawer:
        if index not in names:
            raise InputError("no OpenGL")
        return Drawer(names[index], why)

    unchecked.setattr(device_module, "_probed", probed)
    unchecked.setattr(device_module, "egl_devices", lambda: devices)
    return check_rendering()


def test_a_gpu_that_draws_is_taken_and_handed_on(unchecked: pytest.MonkeyPatch) -> None:
    drawer = drawn(unchecked, {0: "NVIDIA H100", 1: "llvmpipe"}, [NVIDIA, SOFTWARE])
    assert drawer == Drawer("NVIDIA H100", "a GPU, device 0 of EGL")
    assert os.environ[INDEX] == "0"
    check_rendering.cache_clear()
    unchecked.setattr(device_module, "_probed", None)
    assert check_rendering() == drawer, "processes started from here are told"


@pytest.mark.parametrize(
    ("wanted", "names", "name", "why", "index"),
    [
        ("", {1: "llvmpipe"}, "llvmpipe", "no OpenGL", "1"),
        ("", {0: "llvmpipe", 1: "llvmpipe"}, "llvmpipe", "is not a GPU", "1"),
        ("software", {0: "NVIDIA H100", 1: "llvmpipe"}, "llvmpipe", "FOUNDRY_RENDERER=software", "1"),
    ],
)
def test_software_draws_where_the_gpu_does_not_or_where_it_is_asked_for(
    wanted: str, names: dict[int | None, str], name: str, why: str, index: str, unchecked: pytest.MonkeyPatch
) -> None:
    if wanted:
        unchecked.setenv(WANTED, wanted)
    drawer = drawn(unchecked, names, [NVIDIA, SOFTWARE])
    assert drawer.name == name and why in drawer.why and os.environ[INDEX] == index


@pytest.mark.parametrize(("asked", "names"), [("software", {None: "NVIDIA"}), ("gpu", {0: "llvmpipe"})])
def test_what_is_asked_for_and_does_not_draw_is_an_error(
    asked: str, names: dict[int | None, str], unchecked: pytest.MonkeyPatch
) -> None:
    unchecked.setenv(WANTED, asked)
    with pytest.raises(InputError, match=f"FOUNDRY_RENDERER={asked}, but (NVIDIA|llvmpipe) draws here"):
        drawn(unchecked, names, [NVIDIA])


def test_a_device_that_the_environment_names_is_left_to_vtk(unchecked: pytest.MonkeyPatch) -> None:
    unchecked.setenv(INDEX, "3")
    assert drawn(unchecked, {None: "NVIDIA A100"}, [NVIDIA]).why == "VTK chose it"
    assert os.environ[INDEX] == "3"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="EGL's drivers can be hidden on Linux alone")
@pytest.mark.skipif(find_library("OSMesa") is not None, reason="VTK draws with OSMesa where EGL does not work")
def test_a_machine_without_drivers_is_told_which_package_to_install(unchecked: pytest.MonkeyPatch) -> None:
    unchecked.setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nowhere")
    unchecked.setenv("LIBGL_DRIVERS_PATH", "/nowhere")
    with pytest.raises(InputError) as caught:
        check_rendering()
    assert str(caught.value).startswith("This machine cannot draw 3D scenes without a screen (")
    assert str(caught.value).endswith(install_line())
    assert "\n" not in str(caught.value)
