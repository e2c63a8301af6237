"""The pictures of 2D worlds: what each shows, and how to read it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from msgspec.structs import replace

from analysis.figures.shown import Shown, example_caption
from analysis.form import RunTable
from analysis.grid.grid_figures import GridGroup, cascade_tree
from analysis.grid.grid_run import GridRun
from analysis.grid.plots import grid_plots
from analysis.grid.plots.grid_plots import CascadeTree
from analysis.plots import Picture


class GridFigures:
    """Gathers what is shown of runs: where agents were, how news spread, which ways were taken."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._groups: dict[Shown, GridGroup] = {}

    def add(self, shown: Shown, run: GridRun, seed: int) -> None:
        """Take what is shown of a run of a group."""
        world = replace(run.world, places=(), fires=()) if run.world.draw_positions else run.world
        self._groups.setdefault(shown, GridGroup(shown, self._seed, world)).add(run, seed)

    def pictures(self, order: Sequence[Shown]) -> list[Picture]:
        """Return the pictures, the groups in this order."""
        groups = [self._groups[one] for one in order if one in self._groups]
        return [*_of_all_runs(groups), *self._of_single_runs(order)]

    def tables(self, order: Sequence[Shown]) -> list[RunTable]:
        """Return every first warning of the runs that are shown, with its step; nothing where there is none."""
        rows = tuple(
            (tree.run, tree.shown.label, str(edge.step), str(edge.sender), str(edge.recipient))
            for tree in self._trees(order)
            for edge in tree.edges
        )
        caption = f"First warnings in the runs of seed {self._seed}: their lines in messages.jsonl of the run."
        title, columns = "First warnings, step by step", ("run", "group", "step", "sender", "recipient")
        return [RunTable(title, caption, columns, rows, labels=2)] if rows else []

    def _examples(self, order: Sequence[Shown]) -> list[tuple[Shown, GridRun]]:
        found = ((one, self._groups[one].example) for one in order if one in self._groups)
        return [(one, run) for one, run in found if run is not None]

    def _trees(self, order: Sequence[Shown]) -> list[CascadeTree]:
        """Return who warned whom in the runs that are shown; nothing where none of them has a fire seen."""
        kept = self._examples(order)
        alarmed = any(run.perceived.any() for _, run in kept)
        return [cascade_tree(run, shown) for shown, run in kept] if alarmed else []

    def _of_single_runs(self, order: Sequence[Shown]) -> list[Picture]:
        fixed, pictures = example_caption(self._seed), []
        trees = self._trees(order)
        if trees:
            caption = (
                f"{fixed} Each dot is an agent at the step at which it learnt of a fire: filled, it saw one itself; "
                "hollow, it was warned; a cross, it warned others before it had learnt anything. A line leads "
                "from who warned first."
            )
            pictures.append(Picture("cascade", "Who warned whom", caption, partial(grid_plots.cascade_figure, trees)))
        examples = self._examples(order)
        if examples:
            caption = f"{fixed} A line an agent, from its start (dot) to its end (ring)."
            pictures.append(Picture("paths", "Ways of the agents", caption, partial(grid_plots.paths_figure, examples)))
        return pictures


def _of_all_runs(groups: Sequence[GridGroup]) -> list[Picture]:
    pictures = []
    maps = [group.occupancy_map() for group in groups]
    if maps:
        caption = (
            "Share of all agent-steps by cell, mean over the complete runs, the start left out; all on one scale, "
            "which ends with the models. "
            "Outlines: places; crosses and dashed rings: fires and how far they are perceived; neither where each run "
            "has its own."
        )
        pictures.append(
            Picture("occupancy", "Where the agents were", caption, partial(grid_plots.occupancy_figure, maps))
        )
    curves = [curve for curve in (group.survival_curve() for group in groups) if curve is not None]
    if curves:
        caption = (
            "Kaplan-Meier estimate of the share of agents that nobody has warned yet, one curve a run; line: mean over "
            "runs; band: 95 % interval over runs, not agents. Agents that see a fire first are censored. Runs in which "
            "nobody perceived a fire have no curve."
        )
        # A signature draws under its own name, and `survival` is one of worlds with energy.
        name = "not_warned" if any(group.world.energy for group in groups) else "survival"
        pictures.append(
            Picture(name, "Time to the first warning", caption, partial(grid_plots.survival_figure, curves))
        )
    present = [curve for curve in (group.presence_curve() for group in groups) if curve is not None]
    if present:
        caption = (
            "Share of the agents of the start that have neither left nor died, by step; line: mean over runs; band: "
            "95 % interval over runs, not agents."
        )
        drawn = partial(grid_plots.survival_figure, present, "Still there (share)")
        pictures.append(Picture("presence", "Agents that are still there", caption, drawn))
    return pictures
