"""A backend of one's own that costs something is cached, limited, retried and confirmed as the shipped ones are."""

from __future__ import annotations

from pathlib import Path

import pytest

from commands import foundry, statuses
from foundry.storing.store import SweepFolder
from own_backend import Paid

SMALL = ("world.agents=6", "world.steps=2", "analyze=false", "runner.workers=1")
CALLS = 6 * 2 * 2


@pytest.fixture
def own(workspace: Path, monkeypatch: pytest.MonkeyPatch):
    """Run the command with a backend of this class into a folder of this name."""
    for name, value in (("asked", []), ("most_in_flight", 0), ("digest", None)):
        monkeypatch.setattr(Paid, name, value)
    (workspace / "mine" / "model").mkdir(parents=True)
    for kind in ("Paid", "Slow"):
        file = workspace / "mine" / "model" / f"{kind.lower()}.yaml"
        file.write_text(f"_target_: own_backend.{kind}\nname: {kind.lower()}\n", encoding="utf-8")

    def start(kind: str, output: str):
        arguments = ("--config-dir", "mine", f"model={kind}", f"output.dir={output}", *SMALL)
        return foundry(*arguments, cwd=workspace)

    return start


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "at_once"), [("paid", 64), ("slow", 2)])
def test_what_it_answered_is_not_asked_again_and_what_failed_is_tried_again(own, workspace, kind: str, at_once: int):
    first = own(kind, "one")
    assert first.returncode == 0, first.stdout + first.stderr
    assert len(Paid.asked) == CALLS + 1 and 1 < Paid.most_in_flight <= at_once
    (run,) = SweepFolder.open(workspace / "one").runs()
    assert [attempt.error for call in run.calls() for attempt in call.attempts] == ["Not yet."]
    assert own(kind, "two").returncode == 0
    assert len(Paid.asked) == CALLS + 1 and statuses(workspace / "two") == ["complete"]


def test_one_that_says_by_an_old_name_that_it_costs_something_is_refused_before_it_is_asked(
    own, workspace, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(Paid, "remote", True, raising=False)
    done = own("paid", "one")
    assert done.returncode == 2 and "has an attribute `remote`: it is called `costs` now" in done.stderr
    assert done.stderr.count("\n") == 1 and Paid.asked == [] and not (workspace / "one").exists()


def test_weights_that_it_says_have_changed_stop_the_sweep(own, workspace, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(Paid, "digest", "first")
    ask = Paid.ask

    async def replaced(self, request):
        Paid.digest = "second" if len(Paid.asked) > CALLS // 2 else Paid.digest
        return await ask(self, request)

    monkeypatch.setattr(Paid, "ask", replaced)
    done = own("paid", "one")
    assert done.returncode == 3 and "digest first when it began, second now" in done.stderr
    assert statuses(workspace / "one") == ["failed"]
