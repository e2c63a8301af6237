"""Shows runs of 3D worlds (form `camera`) on the page."""

from foundry.viewer.camera.camera_view import CameraView
from foundry.viewer.forms import FormView

VIEWER = FormView(CameraView)
