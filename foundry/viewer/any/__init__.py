"""Shows on the page the data that runs of all forms have, such as decisions, messages and curves."""

from foundry.viewer.any.any_view import AnyView
from foundry.viewer.forms import FormView

VIEWER = FormView(AnyView)
