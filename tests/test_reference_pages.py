"""The lists in the reference pages are those that the code gives."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from reference_pages import PAGES, with_list


@pytest.mark.parametrize(("path", "listed"), PAGES.items(), ids=lambda value: getattr(value, "name", ""))
def test_the_list_of_a_reference_page_is_what_the_code_says(path: Path, listed: Callable[[], str]):
    page = path.read_text(encoding="utf-8")
    assert page == with_list(page, listed()), "run `python docs/reference_pages.py`"
