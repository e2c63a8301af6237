"""The view of runs of the camera form."""

from foundry.viewer.camera.camera_view import CameraView
from foundry.viewer.forms import FormView

VIEWER = FormView(CameraView)
