"""Fills the templates: pages, and texts for a paper."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from analysis.prose import joined

_STYLE = re.compile(r' style="([^"]*)"')


def rendered(template: str, content: Mapping[str, Any]) -> str:
    """Return a page or a text of `templates/`, filled."""
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
    text = environment.get_template(template).render(content)
    return _with_shared_styles(text) if template.endswith(".html") else text


def _with_shared_styles(page: str) -> str:
    """Return the page with the styles that several of its elements have in its style sheet, each under a short class.

    Args:
        page: HTML that has a style sheet of its own, and no element with both a style and a class.
    """
    counted = Counter(_STYLE.findall(page))
    shared = [style for style, count in counted.most_common() if count > 1]
    names = {style: f"s{number}" for number, style in enumerate(shared)}
    sheet = "".join(f".{name}{{{style}}}" for style, name in names.items())

    def named(found: re.Match[str]) -> str:
        return f' class="{names[found[1]]}"' if found[1] in names else found[0]

    return _STYLE.sub(named, page).replace("</style>", f"{sheet}</style>", 1)
