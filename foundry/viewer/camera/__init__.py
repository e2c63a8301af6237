"""Runs of the camera form in the viewer."""

from foundry.viewer.camera.camera_view import CameraView
from foundry.viewer.forms import FormView

VIEWER = FormView(CameraView)
