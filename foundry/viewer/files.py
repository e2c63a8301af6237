"""The files of a sweep's folder that a page may show, and the files of the page itself."""

from __future__ import annotations

from pathlib import Path

import msgspec

from foundry import palette

STATIC = Path(__file__).resolve().parent / "static"
"""The page, its scripts and styles."""
ROOMS = {folder.parent.name: folder for folder in sorted(STATIC.parent.glob("*/static"))}
"""The folders of scripts and styles that lie beside their server's part, by the first part of their addresses."""

MEDIA_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".csv": "text/csv; charset=utf-8",
    ".md": "text/plain; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".jpg": "image/jpeg",
    ".jpeg": "image/jpeg",
    ".woff2": "font/woff2",
    ".wasm": "application/wasm",
}
"""Files of other kinds are not handed out."""

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'"
)
"""The page's Content-Security-Policy: nothing inline, nothing from anywhere else. The page repeats it for file://."""

REPORT_POLICY = (
    "sandbox allow-scripts allow-popups; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src 'self' data:; font-src data:"
)
"""For documents of the sweep's folder: they come from nowhere, and can reach neither the page nor its data."""


PALETTE = "palette.js"
"""The address of the script that says how models and labels look, beside the files of the page."""


def palette_script() -> bytes:
    """Return the script from which the page takes the colours, markers and dashes of `foundry.palette`."""
    told = {
        "colours": palette.COLOURS,
        "baseline": palette.BASELINE,
        "markers": palette.MARKERS,
        "dashes": palette.DASHES,
        "labels": palette.LABELS,
        "turn": palette.TURN,
    }
    return b'"use strict";Foundry.palette=%s;\n' % msgspec.json.encode(told)


def inside(root: Path, relative: str) -> Path | None:
    """Return the file below `root`; None when there is none, when it leads outside, or for kinds not handed out."""
    if "\0" in relative or "\\" in relative:
        return None
    path = (root / relative).resolve()
    if not path.is_relative_to(root.resolve()) or path.suffix not in MEDIA_TYPES or not path.is_file():
        return None
    return path


def static_file(relative: str) -> Path | None:
    """Return a file of the page; `source.js` is how it gets its data: by HTTP."""
    room, _, name = relative.partition("/")
    if room in ROOMS:
        return inside(ROOMS[room], name)
    return inside(STATIC, {"": "index.html", "source.js": "source_http.js"}.get(relative, relative))
