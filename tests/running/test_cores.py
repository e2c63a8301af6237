"""Workers that draw share the cores."""

import gc
import os

import pytest

from foundry.running.cores import garbage_sought_seldom, share_cores, threads_of


@pytest.mark.parametrize(
    ("cores", "workers", "threads"), [(2, 1, 2), (2, 2, 0), (16, 2, 8), (16, 5, 3), (4, 3, 0), (1, 8, 0)]
)
def test_each_worker_draws_with_its_part_of_the_cores_and_by_itself_with_one(
    cores: int, workers: int, threads: int
) -> None:
    assert threads_of(cores, workers) == threads


def test_what_the_environment_says_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LP_NUM_THREADS", "7")
    share_cores(2)
    assert os.environ["LP_NUM_THREADS"] == "7"


def test_while_a_worker_works_garbage_is_sought_less_often() -> None:
    kept = gc.get_threshold()
    gc.set_threshold(700, 10, 10)
    try:
        with garbage_sought_seldom():
            assert gc.get_threshold()[0] > 700
        assert gc.get_threshold() == (700, 10, 10)
    finally:
        gc.set_threshold(*kept)
