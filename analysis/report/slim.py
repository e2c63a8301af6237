"""Makes a page shorter that looks the same."""

from __future__ import annotations

import re
from collections import Counter

_STYLE = re.compile(r' style="([^"]*)"')


def with_shared_styles(page: str) -> str:
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
