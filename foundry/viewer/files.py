"""The files of a sweep's folder that a page may show, and the page's own files."""

from pathlib import Path

import msgspec

from foundry import palette

STATIC = Path(__file__).resolve().parent / "static"
"""The folder of the page, its scripts and styles."""
ROOMS = {folder.parent.name: folder for folder in sorted(STATIC.parent.glob("*/static"))}
"""Further folders of scripts and styles; the key is the first part of the addresses of their files."""

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
"""Media types of files by their ending. The server sends only files with these endings."""

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'"
)
"""The Content-Security-Policy of served and exported pages, which forbids inline and external code."""

REPORT_POLICY = (
    "sandbox allow-scripts allow-popups; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src 'self' data:; font-src data:"
)
"""The Content-Security-Policy of reports in a sweep's folder: they cannot reach the page and its data."""

PALETTE = "palette.js"
"""Address of the script with the colours and markers of models and labels, next to the page's files."""


def palette_script() -> bytes:
    """Return the script with the colours, markers and dashes of `foundry.palette`."""
    names = ("COLOURS", "DARK_COLOURS", "BASELINE", "MARKERS", "DASHES", "LABELS", "TURN")
    looks = {name.lower(): getattr(palette, name) for name in names}
    return b'"use strict";Foundry.palette=%s;\n' % msgspec.json.encode(looks)


def inside(root: Path, relative: str) -> Path | None:
    """Return a file below `root`; None if it is missing, lies outside `root`, or has a type that is not sent."""
    if "\0" in relative or "\\" in relative:
        return None
    path = (root / relative).resolve()
    if not path.is_relative_to(root.resolve()) or path.suffix not in MEDIA_TYPES or not path.is_file():
        return None
    return path


def static_file(relative: str) -> Path | None:
    """Return a file of the page by its address. For `source.js`, return the script that loads data by HTTP."""
    room, _, name = relative.partition("/")
    if room in ROOMS:
        return inside(ROOMS[room], name)
    return inside(STATIC, {"": "index.html", "source.js": "source_http.js"}.get(relative, relative))
