"""The list of docs/signatures.md is what the modules of the signatures say."""

from __future__ import annotations

from signature_page import PAGE, with_list


def test_the_list_of_signatures_is_what_their_modules_say():
    page = PAGE.read_text(encoding="utf-8")
    assert page == with_list(page), "run `python benchmarks/signature_page.py`"
