"""Shows a run of any form on the page, without what is special to a form."""

from foundry.viewer.any.any_view import AnyView
from foundry.viewer.forms import FormView

VIEWER = FormView(AnyView)
