"""Runs of any form in the viewer: what all of them share."""

from foundry.viewer.any.any_view import AnyView
from foundry.viewer.forms import FormView

VIEWER = FormView(AnyView)
