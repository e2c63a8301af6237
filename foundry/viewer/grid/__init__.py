"""Runs of the grid form in the viewer."""

from foundry.viewer.forms import FormView
from foundry.viewer.grid.grid_view import GridView

VIEWER = FormView(GridView)
