"""The view of runs of any form, with the parts that all forms share."""

from foundry.viewer.any.any_view import AnyView
from foundry.viewer.forms import FormView

VIEWER = FormView(AnyView)
