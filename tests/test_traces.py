"""A command that is run in the tests' own process, and each test, leave that process as they found it."""

import logging
import os
import signal
import sys
from pathlib import Path

from commands import succeeds
from foundry.storing.store import SweepFolder
from traces import no_traces

POLICY = """
from foundry.models.base import Reply
from foundry.worlds.any.any_policies import Stay


class Sole(Stay):
    def reply(self, request):
        return Reply(text="{text}")
"""
SMALL = ("model=sole", "world.agents=2", "world.steps=1", "analyze=false", "runner.workers=1", "output.dir=out")


def said(folder: Path, text: str) -> set[str]:
    """Run a policy of a user's own, of the one name that all have; return what it said."""
    (folder / "mine" / "model").mkdir(parents=True)
    (folder / "mine" / "sole.py").write_text(POLICY.format(text=text), encoding="utf-8")
    (folder / "mine" / "model" / "sole.yaml").write_text("_target_: sole.Sole\nname: sole\n", encoding="utf-8")
    succeeds("--config-dir", "mine", *SMALL, cwd=folder)
    return {call.text for run in SweepFolder.open(folder / "out").runs() for call in run.calls()}


def test_each_command_imports_the_module_of_its_own_folder_though_all_have_one_name(tmp_path: Path):
    before = (dict(os.environ), list(sys.path))
    assert said(tmp_path / "one", "left") == {"left"} and said(tmp_path / "two", "right") == {"right"}
    assert "sole" not in sys.modules and (dict(os.environ), list(sys.path)) == before


def test_what_is_set_in_a_process_is_taken_back():
    kept, library = sys.path, logging.getLogger("foundry")
    before = (dict(os.environ), list(sys.path), signal.getsignal(signal.SIGINT), library.level, list(library.handlers))
    with no_traces():
        os.environ["FOUNDRY_MINE"] = "elsewhere"
        del os.environ["FOUNDRY_WORKERS"]
        sys.path.append("elsewhere")
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        library.setLevel(logging.CRITICAL)
        library.addHandler(logging.NullHandler())
    after = (dict(os.environ), list(sys.path), signal.getsignal(signal.SIGINT), library.level, list(library.handlers))
    assert after == before and sys.path is kept
