"""Runs a sweep with people, who answer questions on a page."""

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
    """Plays the missing runs of a sweep while people answer questions on a page.

    Attributes:
        session: beginning of its worker's name.
    """

    def __init__(self, desk: Desk, *, together: bool) -> None:
        """Set the desk.

        Args:
            desk: the desk at which questions wait for people.
            together: whether questions of several runs may wait at once, as in a probe; else one run is played after
                another.
        """
        super().__init__(workers=1, ahead=False)
        self.session = new_session()
        self._desk = desk
        self._at_once = MOST_OPEN if together else 1

    def spec(self, job: SweepJob, runs: Sequence[RunFolder], number: int) -> LaneSpec:
        """Return the settings of a worker: the usual settings, but another number of runs that it plays at once."""
        return replace(super().spec(job, runs, number), open_runs=self._at_once)

    def run(self, job: SweepJob) -> None:
        """Play all runs that have not ended; when this returns, no question is open.

        Raises:
            SweepStopped: an error would end every further run too.
            SweepInterrupted: a user asked to stop.
        """
        with seated(self._desk):
            super().run(replace(job, session=self.session))


def people_in(sweep: Sweep) -> list[str]:
    """Return the names of people among a sweep's models and members of populations."""
    configs = {settings_key(condition.config["model"]): condition.config["model"] for condition in sweep.conditions}
    models = (member for config in configs.values() for member in members_of(build(config)))
    return list(dict.fromkeys(model.name for model in models if isinstance(model, HumanModel)))


def people_to_ask(sweep: Sweep) -> list[str]:
    """Return the names that `people_in` finds, and raise an error if it finds none.

    Raises:
        InputError: there are none.
    """
    names = people_in(sweep)
    if not names:
        raise InputError(
            "No person takes part. Name one among the models, as in model=human/<name> or "
            "model=mix/human/<name>@0+<model>@1-9, or use foundry without 'play'."
        )
    return names


def how_far(folder: SweepFolder) -> Callable[[], float]:
    """Return a function that computes how much of a sweep is done: the share (0..1) of its maximum number of calls."""
    progress = SweepProgress(folder)

    def share() -> float:
        totals = progress.by_model().values()
        return sum(total.done for total in totals) / max(1, sum(total.most for total in totals))

    return share
