"""Opens the cache of answers at an address."""

from pathlib import Path

from foundry.models.answers.answers import Answers, is_database


def open_answers(where: str | Path) -> Answers:
    """Open a cache, or create it: a file, or a database such as `postgresql://host/database`."""
    if is_database(where):
        from foundry.models.answers.postgres import PostgresAnswers

        return PostgresAnswers(str(where))
    from foundry.models.answers.sqlite import SqliteAnswers

    return SqliteAnswers(Path(where))


def existing_answers(where: str | Path) -> Answers | None:
    """Open a cache, or return None if it does not exist."""
    return open_answers(where) if is_database(where) or Path(where).exists() else None


def check_reachable(where: str) -> None:
    """Open the cache once if it is a database, so that a wrong address is reported before a sweep starts."""
    if is_database(where):
        open_answers(where).close()
