"""The sweep of the form that stands outside the package: one for all tests of this folder, which leave it as it is."""

from __future__ import annotations

import pytest

from outside_form import Outside, play


@pytest.fixture(scope="session")
def outside(tmp_path_factory: pytest.TempPathFactory) -> Outside:
    """The user's folder with the finished sweep beside it."""
    return play(tmp_path_factory.mktemp("outside"))
