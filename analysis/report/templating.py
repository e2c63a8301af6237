"""Fills the templates of pages and of texts for a paper."""

from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from analysis.prose import joined
from foundry.texts import counted


def rendered(template: str, content: Mapping[str, Any]) -> str:
    """Return a filled template of `templates/`, a page or a text."""
    import jinja2

    templates = files("analysis.report") / "templates"
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: (templates / name).read_text(encoding="utf-8")),
        autoescape=jinja2.select_autoescape(),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["joined"] = joined
    environment.filters["counted"] = counted
    return environment.get_template(template).render(content)
