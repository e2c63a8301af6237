"""Saves figures to files; equal figures give equal bytes."""

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
_LOOK = f"stroke-linejoin:round;stroke-linecap:butt;font-family:{','.join(_SVG_FONTS)},sans-serif"


@contextmanager
def styled(columns: int = 1) -> Iterator[None]:
    """Apply the style of this package to figures that are as wide as the given number of columns of a paper."""
    import matplotlib

    with matplotlib.rc_context(), warnings.catch_warnings():
        # A letter in a script without an installed font is drawn as a box, which is visible and so no error.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(style.settings(columns))
        yield


def settle(figure: Figure) -> None:
    """Compute the layout once, so that it is equal in all formats."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")


def png_bytes(figure: Figure) -> bytes:
    """Return the figure as PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure.dpi = style.DPI  # other formats change it
    written = io.BytesIO()
    # No software entry: its version would change the bytes. The canvas writes once; `savefig` would draw twice.
    FigureCanvasAgg(figure).print_png(written, metadata={"Software": None})  # type: ignore[no-untyped-call]
    return written.getvalue()


def pdf_bytes(figure: Figure) -> bytes:
    """Return the figure as PDF with embedded text."""
    from matplotlib.backends.backend_pdf import FigureCanvasPdf

    written = io.BytesIO()
    FigureCanvasPdf(figure).print_pdf(  # type: ignore[no-untyped-call]
        written, metadata=dict.fromkeys(("CreationDate", "Creator", "Producer"))
    )
    return written.getvalue()


def svg_text(figure: Figure, name: str) -> str:
    """Return the figure as SVG for a page, with ids that begin with a hash of the figure's name."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    written = io.StringIO()
    FigureCanvasSVG(figure).print_svg(written, metadata=_NO_METADATA)  # type: ignore[no-untyped-call]
    text = written.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(
        r"<!--.*?-->|<metadata>.*?</metadata>|<defs>\s*<style.*?</style>\s*</defs>", "", text, flags=re.DOTALL
    )
    text = re.sub(r"<[^>]+>", lambda match: _slim(match[0]), re.sub(r">\s+<", "><", text))
    text = text.replace("<svg ", f'<svg style="{_LOOK}" ', 1)
    return _own_ids(text, hashlib.sha256(name.encode()).hexdigest()[:6] + "-").strip() + "\n"


def _slim(tag: str) -> str:
    """Leave out the fonts of a tag, which are set for the whole picture, and shorten its numbers."""
    tag = re.sub(r"font-family: [^;\"]*;? ?", "", tag)
    return re.sub(r"\d+\.\d{3,}", lambda match: f"{float(match[0]):.2f}", tag)


def _own_ids(text: str, prefix: str) -> str:
    """Remove ids to which nothing in the SVG refers; rename all other ids to the prefix and a number."""
    wanted = dict.fromkeys(re.findall(r'(?:url\(|href=")#([^)"]+)', text))
    names = {name: f"{prefix}{number}" for number, name in enumerate(wanted)}
    text = re.sub(r' id="([^"]*)"', lambda match: f' id="{names[match[1]]}"' if match[1] in names else "", text)
    return re.sub(r'(url\(#|href="#)([^)"]+)', lambda match: match[1] + names[match[2]], text)
