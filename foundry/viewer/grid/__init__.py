"""Shows runs of 2D worlds (form `grid`) on the page."""

from foundry.viewer.forms import FormView
from foundry.viewer.grid.grid_view import GridView

VIEWER = FormView(GridView)
