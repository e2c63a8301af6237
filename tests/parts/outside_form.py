"""A form and a world that stand outside the package, in a folder beside a sweep that was run with them."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from commands import foundry


@dataclass(frozen=True)
class Outside:
    """A user's folder `mine` and a sweep `out`, both in `cwd`.

    Attributes:
        cwd: where the commands are started.
        printed: what running the sweep said.
    """

    cwd: Path
    printed: str

    @property
    def sweep(self) -> Path:
        return self.cwd / "out"

    def foundry(self, *arguments: str) -> str:
        """Run a command that ends well, with the user's folder; return what it printed."""
        done = foundry(*arguments, "--config-dir", "mine", cwd=self.cwd)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout


def play(cwd: Path) -> Outside:
    """Copy the user's folder into this one, and run the sweep of two models and two seeds on the ring."""
    mine = Path(__file__).parents[1] / "outside" / "mine"
    shutil.copytree(mine, cwd / "mine", ignore=shutil.ignore_patterns("__pycache__"))
    asked = ("-m", "world=ring", "prompt=ring", "model=walker,other", "seed=0-1", "output.dir=out", "runner.workers=1")
    cache = f"cache.path={cwd / 'answers.sqlite'}"
    done = foundry("--config-dir", "mine", *asked, cache, "analyze=false", cwd=cwd)
    assert done.returncode == 0, done.stdout + done.stderr
    return Outside(cwd, done.stdout)
