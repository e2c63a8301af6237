"""What tests of crashes share: calls that are held back, and the proof that nothing was lost, paid twice or changed."""

import contextlib
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from commands import SMALL, cached_answers, calls, records, started, statuses, wait_until
from foundry.storing.store import SweepFolder
from ollama_cases import Body, ChatCase, grid_answer
from ollama_server import OllamaServer

SWEEP = ("-m", "model=qwen3:4b", "seed=0-5", *SMALL)
CALLS = 6 * 4 * 4 * 2


class Holding:
    """Answers the first `count` calls and holds every later one back, until `free`."""

    def __init__(self, count: int) -> None:
        self.left = count
        self.held = False

    def __call__(self, body: Body) -> str | ChatCase:
        if self.left > 0:
            self.left -= 1
            return grid_answer(body)
        self.held = True
        return ChatCase(hang=True)

    def free(self) -> None:
        self.left = 10**9


@dataclass
class HeldSweep:
    """A command at work in `cwd`, whose server holds its calls back."""

    server: OllamaServer
    process: subprocess.Popen[str]
    cwd: Path
    holding: Holding

    def wait_until_cached(self, answers: int) -> None:
        cache = self.cwd / "outputs" / "answers.sqlite"
        wait_until(lambda: cached_answers(cache) == answers, "every answer given is in the cache", self.process)

    def finish(self) -> str:
        """Answer all calls, the held ones when they are made again; return what the command said until its end."""
        self.holding.free()
        self.server.drop_hanging()
        return self.process.communicate()[0]


@contextlib.contextmanager
def held_sweep(answers: int, *arguments: str, cwd: Path) -> Iterator[HeldSweep]:
    """Start a command on a server that holds back every call after so many; yield when it holds the first one."""
    holding = Holding(answers)
    with OllamaServer(holding) as server, started(*arguments, cwd=cwd, OLLAMA_HOST=server.url) as process:
        wait_until(lambda: holding.held, "the calls are held back", process)
        yield HeldSweep(server, process, cwd, holding)


def working(folder: Path) -> list[dict[str, Any]]:
    return [report for report in SweepFolder.open(folder).progress().values() if report["open"]]


def assert_nothing_lost_or_paid_twice(server: OllamaServer, folder: Path, undisturbed: Path) -> None:
    assert set(statuses(folder)) == {"complete"}
    assert set(server.answered.values()) == {1}
    assert len(server.answered) == CALLS
    assert records(folder) == records(undisturbed)
    assert calls(folder) == calls(undisturbed)
