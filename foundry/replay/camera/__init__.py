"""Runs of the camera form in a window."""

from foundry.replay.camera.window import CameraWindow

WINDOW = CameraWindow
