"""The caches of answers that the tests of models share."""

from pathlib import Path

import pytest

from databases import PostgresStore, SqliteStore, Store


@pytest.fixture(params=["sqlite", pytest.param("postgres", marks=pytest.mark.cluster)])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Store:
    if request.param == "sqlite":
        return SqliteStore(tmp_path)
    return PostgresStore(request.getfixturevalue("postgres").database())
