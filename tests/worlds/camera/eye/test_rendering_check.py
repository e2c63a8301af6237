"""A machine that cannot draw is told so in one line, before VTK crashes."""

from __future__ import annotations

import os
import subprocess
import sys
from ctypes.util import find_library

import pytest

from foundry.errors import InputError
from foundry.worlds.camera.eye.glcheck import check_rendering, choose_window, install_line


@pytest.fixture
def unchecked(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """An environment in which nothing has been looked at yet."""
    check_rendering.cache_clear()
    monkeypatch.setenv("_FOUNDRY_RENDERING_WORKS", "")
    return monkeypatch


def test_a_machine_that_can_draw_passes_and_is_asked_once(unchecked: pytest.MonkeyPatch) -> None:
    check_rendering()
    unchecked.setattr(subprocess, "run", None)
    check_rendering()
    check_rendering.cache_clear()
    check_rendering()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="EGL's drivers can be hidden on Linux alone")
@pytest.mark.skipif(find_library("OSMesa") is not None, reason="VTK draws with OSMesa where EGL does not work")
def test_a_machine_without_drivers_is_told_which_package_to_install(unchecked: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        unchecked.delenv(name, raising=False)
    unchecked.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    unchecked.setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nowhere")
    unchecked.setenv("LIBGL_DRIVERS_PATH", "/nowhere")
    with pytest.raises(InputError) as caught:
        check_rendering()
    assert str(caught.value).startswith("This machine cannot draw 3D scenes without a screen (")
    assert str(caught.value).endswith(install_line())
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems have one kind of window")
def test_only_a_linux_machine_without_a_screen_draws_through_egl(monkeypatch: pytest.MonkeyPatch) -> None:
    name = "VTK_DEFAULT_OPENGL_WINDOW"
    monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("DISPLAY", ":0")
    choose_window()
    assert name not in os.environ
    monkeypatch.delenv("DISPLAY")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    choose_window()
    assert os.environ[name] == "vtkEGLRenderWindow"
