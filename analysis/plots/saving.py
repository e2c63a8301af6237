"""Figures to files: the same figure gives the same bytes."""

from __future__ import annotations

import hashlib
import io
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from analysis.plots import style
from foundry.palette.fonts import FALLBACK_FONTS, USUAL_FONT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NO_METADATA = dict.fromkeys(("Date", "Creator", "Format", "Type"))
_SVG_FONTS = (USUAL_FONT, "Verdana", *FALLBACK_FONTS)
_SAME_LOOK = re.compile(r'<use [^>]*? style="([^"]*)"/>(?:<use [^>]*? style="\1"/>)+')
_ROUND = re.compile(r'<path id="([^"]*)" d="M 0 ([\d.]+) C [^"]*z ?"/>')
_SAME_DOTS = re.compile(
    r'<use xlink:href="#([^"]*)" x="[^"]*" y="[^"]*" style="([^"]*)"/>(?:<use xlink:href="#\1" [^>]* style="\2"/>)+'
)
_UNUSED = re.compile(r"<defs>(?:<path (?![^>]*\bid=)[^>]*/>)+</defs>")
_PLACES = re.compile(r' (?:d|x|y)="[^"]*"')
_PATH = re.compile(r' d="([^"]*)"')
_GROUP = re.compile(r"<g(?: [^>]*)?>|</g>")
_LOOK = f"stroke-linejoin:round;stroke-linecap:butt;font-family:{','.join(_SVG_FONTS)},sans-serif"


@contextmanager
def styled(columns: int = 1) -> Iterator[None]:
    """Let figures be made and written in the style of this package, so many columns of a paper wide."""
    import matplotlib

    with matplotlib.rc_context(), warnings.catch_warnings():
        # A name in a script that no installed font has is drawn as boxes; that is seen, and no cause to stop.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(style.settings(columns))
        yield


def settle(figure: Figure) -> None:
    """Lay the figure out once, so that every format shows the same and none takes the time again."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")


def png_bytes(figure: Figure) -> bytes:
    """Return the figure as PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    written = io.BytesIO()
    # No software entry: its version would change the bytes. The canvas writes at once what `savefig` draws twice.
    FigureCanvasAgg(figure).print_png(written, metadata={"Software": None})  # type: ignore[no-untyped-call]
    return written.getvalue()


def pdf_bytes(figure: Figure) -> bytes:
    """Return the figure as PDF, with its letters as letters."""
    from matplotlib.backends.backend_pdf import FigureCanvasPdf

    written = io.BytesIO()
    FigureCanvasPdf(figure).print_pdf(  # type: ignore[no-untyped-call]
        written, metadata=dict.fromkeys(("CreationDate", "Creator", "Producer"))
    )
    return written.getvalue()


def svg_text(figure: Figure, name: str) -> str:
    """Return the figure as SVG, without a declaration of its own, so that it can stand in a page.

    Args:
        figure: what to write.
        name: decides what is put before every id, so that several figures can stand in one page.
    """
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    written = io.StringIO()
    FigureCanvasSVG(figure).print_svg(written, metadata=_NO_METADATA)  # type: ignore[no-untyped-call]
    text = written.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(
        r"<!--.*?-->|<metadata>.*?</metadata>|<defs>\s*<style.*?</style>\s*</defs>", "", text, flags=re.DOTALL
    )
    text = re.sub(r"<[^>]+>", lambda found: _slim(found[0]), text)
    text = re.sub(r">\s+<", "><", text)
    text = _with_short_dots(text)
    text = _SAME_LOOK.sub(lambda found: f'<g style="{found[1]}">{found[0].replace(_style(found[1]), "")}</g>', text)
    text = _own_ids(text, hashlib.sha256(name.encode()).hexdigest()[:6] + "-").replace("<g/>", "")
    text = _PATH.sub(lambda found: f' d="{_short_path(found[1])}"', _UNUSED.sub("", text))
    return _without_bare_groups(text).strip() + "\n"


def _short_path(path: str) -> str:
    """Return a path without blanks that only people need; what follows a move is a line anyway."""
    path = re.sub(r" ?([A-Za-z]) ?", r"\1", path)
    return path.replace("L", " ") if set(re.findall("[A-Za-z]", path)) <= {"M", "L", "z"} else path


def _without_bare_groups(text: str) -> str:
    """Return the SVG without the groups that say nothing."""
    kept: list[bool] = []

    def tag(found: re.Match[str]) -> str:
        if found[0] != "</g>":
            kept.append(found[0] != "<g>")
            return found[0] if kept[-1] else ""
        return "</g>" if kept.pop() else ""

    return _GROUP.sub(tag, text)


def _with_short_dots(text: str) -> str:
    """Return the SVG with rows of equal round marks as one line of dots, a third as long and the same to the eye."""
    radii = {name: float(radius) for name, radius in _ROUND.findall(text)}

    def dots(found: re.Match[str]) -> str:
        name, look = found[1], found[2]
        if name not in radii:
            return found[0]
        places = re.findall(r'x="([^"]*)" y="([^"]*)"', found[0])
        line = "".join(f"M{x} {y}h0" for x, y in places)
        stroke = look.replace("fill", "stroke")
        return f'<path d="{line}" style="fill:none;{stroke};stroke-width:{2 * radii[name]:g};stroke-linecap:round"/>'

    return _SAME_DOTS.sub(dots, text)


def _style(look: str) -> str:
    return f' style="{look}"'


def _slim(tag: str) -> str:
    """Return a tag without what no eye can tell apart: fonts on every text, digits of places beyond the first."""
    tag = re.sub(r"font-family: [^;\"]*;? ?", "", tag)
    tag = re.sub(r' transform="rotate\(-0 [^"]*"', "", tag)
    tag = re.sub(r"\d+\.\d{3,}", lambda found: _rounded(found[0], 2), tag)
    tag = _PLACES.sub(lambda found: re.sub(r"\d+\.\d{2,}", lambda one: _rounded(one[0], 1), found[0]), tag)
    tag = " ".join(tag.split()).replace("; ", ";").replace(": ", ":")
    return tag.replace("<svg ", f'<svg style="{_LOOK}" ', 1)


def _rounded(text: str, digits: int) -> str:
    return f"{float(text):.{digits}f}".rstrip("0").rstrip(".")


def _own_ids(text: str, prefix: str) -> str:
    """Return the SVG with those ids alone that are referred to, numbered behind a prefix."""
    wanted = dict.fromkeys(re.findall(r'(?:url\(|href=")#([^)"]+)', text))
    names = {name: f"{prefix}{number}" for number, name in enumerate(wanted)}
    text = re.sub(r' id="([^"]*)"', lambda found: f' id="{names[found[1]]}"' if found[1] in names else "", text)
    return re.sub(r'(url\(#|href="#)([^)"]+)', lambda found: found[1] + names[found[2]], text)
