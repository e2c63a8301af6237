"""People at a page: runs a sweep in which they are asked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from foundry.errors import InputError
from foundry.expansion import Sweep, settings_key
from foundry.models.human.desk import Desk, seated
from foundry.models.human.human_model import HumanModel
from foundry.running.build import build, members_of
from foundry.running.lane import MOST_OPEN, LaneSpec
from foundry.running.local import LocalRunner, SweepJob, new_session
from foundry.running.progress import SweepProgress
from foundry.storing.store import RunFolder, SweepFolder


class SittingRunner(LocalRunner):
    """Runs what a sweep still lacks while people sit at a desk.

    Attributes:
        session: what its worker's name begins with, known before the page on which a person can end it.
    """

    def __init__(self, desk: Desk, *, together: bool) -> None:
        """Set where people are asked.

        Args:
            desk: where their questions wait.
            together: whether the questions of all runs wait at once, as those of a probe may; else a run is played
                after another, and round by round.
        """
        super().__init__(workers=1, ahead=False)
        self.session = new_session()
        self._desk = desk
        self._at_once = MOST_OPEN if together else 1

    def spec(self, job: SweepJob, runs: Sequence[RunFolder], number: int) -> LaneSpec:
        """Return what the one worker is given."""
        return replace(super().spec(job, runs, number), open_runs=self._at_once)

    def run(self, job: SweepJob) -> None:
        """Run everything that has not ended; nothing is asked any more when this returns.

        Raises:
            SweepStopped: a failure that no further run could escape.
            SweepInterrupted: someone asked to stop.
        """
        with seated(self._desk):
            super().run(replace(job, session=self.session))


def people_in(sweep: Sweep) -> list[str]:
    """Return the names of the models of a sweep that are people, those in populations among them."""
    configs = {settings_key(one.config["model"]): one.config["model"] for one in sweep.conditions}
    models = (member for config in configs.values() for member in members_of(build(config)))
    return list(dict.fromkeys(model.name for model in models if isinstance(model, HumanModel)))


def people_to_ask(sweep: Sweep) -> list[str]:
    """Return the names of the people among the models of a sweep.

    Raises:
        InputError: there are none.
    """
    names = people_in(sweep)
    if not names:
        raise InputError(
            "Nobody is asked here: name a person among the models, model=human/<name> or "
            "model=mix/human/<name>@0+<model>@1-9, or leave out 'play'."
        )
    return names


def how_far(folder: SweepFolder) -> Callable[[], float]:
    """Return what says how far a sweep is, 0..1: calls that were made, or will not be, of all that it makes at most."""
    progress = SweepProgress(folder)

    def share() -> float:
        totals = progress.by_model().values()
        return sum(one.done for one in totals) / max(1, sum(one.most for one in totals))

    return share
