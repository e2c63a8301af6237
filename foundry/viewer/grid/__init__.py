"""The view of runs of the grid form."""

from foundry.viewer.forms import FormView
from foundry.viewer.grid.grid_view import GridView

VIEWER = FormView(GridView)
