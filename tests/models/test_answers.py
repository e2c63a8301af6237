"""The cache of answers: the same for a file and for a database server."""

import contextlib
import sqlite3
import threading
from pathlib import Path

import numpy as np
import pytest

from databases import PostgresStore, SqliteStore, Store
from foundry.errors import FoundryError, InputError
from foundry.models.answers.answers import settled
from foundry.models.answers.opening import check_reachable, open_answers
from foundry.models.base import Reply
from ports import reserved_port
from postgres_server import PostgresServer


def test_what_one_connection_kept_another_one_finds_until_a_later_answer_replaces_it(store: Store):
    one, two = store.open(), store.open()
    reply = Reply(text="é\u0000\U0001f600", prompt_tokens=5, timings={"latency": 0.5})
    one.put({"k": reply}, "m")
    assert two.get(["k", "absent"]) == {"k": reply}
    one.close()
    assert two.get(["k"]) == {"k": reply}
    two.close()
    answers = store.open()
    answers.put({"k": Reply(text="first")}, "m")
    answers.put({"k": Reply(text="second")}, "m")
    assert answers.get(["k"])["k"].text == "second"
    answers.close()
    assert store.rows() == 1


def test_many_keys_are_looked_up_at_once_and_no_key_is_no_answer(store: Store):
    answers = store.open()
    answers.put({str(number): Reply(text=str(number)) for number in range(1200)}, "m")
    found = answers.get([str(number) for number in range(0, 1300)])
    assert len(found) == 1200
    assert found["1199"].text == "1199"
    assert answers.get([]) == {}
    answers.put({}, "m")
    answers.close()
    assert store.rows() == 1200


def test_damaged_rows_count_as_absent(store: Store):
    answers = store.open()
    answers.put({"a": Reply(text="one"), "b": Reply(text="two")}, "m")
    store.damage()
    assert answers.get(["a", "b"]) == {}
    answers.put({"a": Reply(text="one")}, "m")
    assert set(answers.get(["a", "b"])) == {"a"}
    answers.close()


def test_a_file_with_flipped_bits_returns_nothing_that_was_not_asked_for(tmp_path: Path):
    """Bits are flipped in the keys and in the places of rows within their pages."""
    store, keys = SqliteStore(tmp_path), [f"{number * 7919 % 300:040x}" for number in range(300)]
    answers = store.open()
    answers.put({key: Reply(text=key) for key in keys}, "m")
    answers.close()
    whole = Path(store.where).read_bytes()
    for flips in range(30):
        rng = np.random.default_rng(flips)
        damaged = bytearray(whole)
        for place in rng.integers(4096, len(whole), 40):
            damaged[place] ^= 1 << int(rng.integers(8))
        path = tmp_path / f"{flips}.sqlite"
        path.write_bytes(damaged)
        with contextlib.suppress(FoundryError):
            answers = open_answers(path)
            for key in keys[::7]:
                with contextlib.suppress(FoundryError):
                    assert {text: reply.text for text, reply in answers.get([key]).items()} in ({}, {key: key})
            answers.close()


def test_all_replies_of_a_transaction_are_kept_or_none(store: Store):
    answers = store.open()
    unfit = {"good": Reply(text="x"), "\udc80": Reply(text="a key that no database takes")}
    with pytest.raises((FoundryError, UnicodeEncodeError)):
        answers.put(unfit, "m")
    assert store.rows() == 0
    answers.put({"good": Reply(text="x")}, "m")
    answers.close()
    assert store.rows() == 1


def test_two_writers_of_the_same_keys_in_other_orders_both_end(store: Store):
    keys = [str(number) for number in range(50)]

    def write(order: list[str]) -> None:
        answers = store.open()
        for _ in range(20):
            answers.put({key: Reply(text=key) for key in order}, "m")
        answers.close()

    assert in_threads(lambda: write(keys), lambda: write(keys[::-1])) == []
    assert store.rows() == 50


def test_a_cache_may_be_created_by_many_at_once(store: Store):
    assert in_threads(*[lambda: store.open().close()] * 8) == []
    assert store.rows() == 0


def test_a_file_that_others_create_at_the_same_moment_is_waited_for(tmp_path: Path):
    for number in range(10):
        together = threading.Barrier(4)

        def opened(path: str = str(tmp_path / f"{number}.sqlite"), together: threading.Barrier = together) -> None:
            together.wait()
            open_answers(path).close()

        assert in_threads(*[opened] * 4) == []


def in_threads(*works) -> list[BaseException]:
    errors: list[BaseException] = []

    def catching(work) -> None:
        try:
            work()
        except (FoundryError, OSError, sqlite3.Error) as error:
            errors.append(error)

    threads = [threading.Thread(target=catching, args=(work,)) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return errors


@pytest.mark.cluster
def test_a_server_that_restarted_is_connected_to_anew(postgres: PostgresServer):
    answers = PostgresStore(postgres.database()).open()
    answers.put({"k": Reply(text="before")}, "m")
    postgres.restart()
    assert answers.get(["k"])["k"].text == "before"
    postgres.restart()
    answers.put({"l": Reply(text="after")}, "m")
    assert set(answers.get(["k", "l"])) == {"k", "l"}
    answers.close()


@pytest.mark.cluster
def test_a_server_that_is_away_is_waited_for(postgres: PostgresServer):
    answers = PostgresStore(postgres.database()).open()
    postgres.stop()
    answers._until_back = answers._until_back.copy(sleep=lambda seconds: postgres.start())
    answers.put({"k": Reply(text="late")}, "m")
    assert answers.get(["k"])["k"].text == "late"
    answers.close()


@pytest.mark.cluster
def test_a_database_that_cannot_be_reached_is_named(postgres: PostgresServer):
    missing = postgres.database().rpartition("/")[0] + "/nowhere"
    with pytest.raises(InputError, match=r"nowhere' cannot be used \(.*does not exist"):
        check_reachable(missing)
    with reserved_port() as port, pytest.raises(InputError, match="cannot be used.*refused"):
        check_reachable(f"postgresql://127.0.0.1:{port}/answers")


@pytest.mark.parametrize(
    "url", ["postgresql://me:secret@host/db", "postgresql://host/db?password=secret", "postgres://:secret@host/db"]
)
def test_a_password_in_an_address_is_refused_and_not_repeated(url: str):
    with pytest.raises(InputError, match="PGPASSWORD or the password file") as refused:
        settled(url)
    assert "secret" not in str(refused.value)
    with pytest.raises(InputError, match="PGPASSWORD"):
        open_answers(url)


def test_a_file_holds_in_any_folder_an_address_stays_and_one_of_another_kind_is_refused(workspace: Path):
    assert settled("a.sqlite") == str(workspace / "a.sqlite")
    assert settled("postgresql://host/db") == "postgresql://host/db"
    with pytest.raises(InputError, match="name a file, or postgresql://HOST/DATABASE"):
        settled("mysql://host/db")


def test_a_file_that_is_no_cache_is_named_with_what_to_do(tmp_path: Path):
    path = tmp_path / "a.sqlite"
    path.write_bytes(b"not a database, but long enough to have a header of its own" * 20)
    with pytest.raises(InputError, match=r"a\.sqlite.*move it away"):
        open_answers(path)
