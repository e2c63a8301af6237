"""What the page's own files may hold; read from the files."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from foundry.viewer.files import POLICY, ROOMS, STATIC, static_file
from foundry.viewer.people.people_server import PAGE

OWN = sorted(
    path
    for folder in (STATIC, *ROOMS.values(), PAGE)
    for path in folder.rglob("*.*")
    if path.suffix in (".js", ".css", ".html") and path.parent.name != "vendor"
)
MARKUP = re.compile(
    r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function|setAttribute\(\"(style|on)|srcdoc|"
    r"createContextualFragment|DOMParser"
)


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.relative_to(STATIC.parent).as_posix())
def test_no_text_can_become_markup_or_code(path: Path):
    assert MARKUP.findall(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.relative_to(STATIC.parent).as_posix())
def test_nothing_is_fetched_from_anywhere_and_no_file_is_long(path: Path):
    text = path.read_text(encoding="utf-8")
    assert [url for url in re.findall(r"https?://[^\s\"')]+", text) if "www.w3.org" not in url] == []
    assert len(text.splitlines()) <= 500


def test_the_page_repeats_the_policy_of_the_server():
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    assert f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">' in page
    assert re.findall(r"<script(?! src=)|<style|\son\w+=", page) == []


def test_every_script_of_the_page_is_there():
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    names = set(re.findall(r'(?:src|href)="([\w./]+)"', page)) - {"source.js", "palette.js"}
    assert [name for name in names if static_file(name) is None] == []
