"""The pictures of 2D worlds: what each shows, and how to read it."""

from collections.abc import Sequence
from functools import partial

from msgspec.structs import replace

from analysis.figures.shown import Shown, example_caption
from analysis.form import RunTable
from analysis.grid.grid_figures import COURSES, MOST_SEEDS, GridGroup, Ways, cascade_tree, divergence
from analysis.grid.grid_run import GridRun
from analysis.grid.plots import grid_plots
from analysis.grid.plots.grid_plots import CascadeTree
from analysis.plots import Picture
from analysis.plots.panel import Scale
from analysis.plots.rounds import curves_figure


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
            drawn = partial(grid_plots.cascade_figure, trees)
            warnings = [(tree.shown.label, tree.edges) for tree in trees]
            pictures.append(Picture("cascade", "Who warned whom", caption, drawn, data=warnings))
        examples = self._examples(order)
        if examples:
            caption = f"{fixed} A line an agent, from its start (dot) to its end (ring)."
            drawn = partial(grid_plots.paths_figure, examples)
            ways = [Ways(shown, run.x, run.y) for shown, run in examples]
            pictures.append(Picture("paths", "Ways of the agents", caption, drawn, data=ways))
        return pictures


def _of_all_runs(groups: Sequence[GridGroup]) -> list[Picture]:
    pictures = []
    maps = [group.occupancy_map() for group in groups]
    if maps:
        caption = (
            "Share of all agent-steps by cell, mean over the complete runs, the start left out. All maps have one "
            "scale, which ends where 95 % of the visited cells lie below, so that a crowded cell leaves the rest seen. "
            "Outlines: places; crosses and dashed rings: fires and how far they are perceived; neither where each run "
            "has its own."
        )
        pictures.append(
            Picture(
                "occupancy", "Where the agents were", caption, partial(grid_plots.occupancy_figure, maps), data=maps
            )
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
            Picture(
                name, "Time to the first warning", caption, partial(grid_plots.survival_figure, curves), data=curves
            )
        )
    present = [curve for curve in (group.presence_curve() for group in groups) if curve is not None]
    if present:
        caption = (
            "Share of the agents of the start that have neither left nor died, by step; line: mean over runs; band: "
            "95 % interval over runs, not agents."
        )
        drawn = partial(grid_plots.survival_figure, present, "Still there (share)")
        pictures.append(Picture("presence", "Agents that are still there", caption, drawn, data=present))
    return [*pictures, *_by_step(groups)]


def _by_step(groups: Sequence[GridGroup]) -> list[Picture]:
    """Return what agents did step by step, and how far the models' agents went apart."""
    pictures = []
    panels = [(title, [group.course(title) for group in groups]) for title in COURSES]
    caption = "Share of the agents by step; line: mean over runs; band: 95 % interval over runs, not agents."
    shares = partial(curves_figure, panels, Scale(0.0, 1.0), "Step")
    pictures.append(Picture("course", "What the agents did, by step", caption, shares, data=panels))
    apart = divergence(groups)
    if apart:
        caption = (
            "How far an agent is from itself in the runs of the same seed by the other groups, mean over agents, "
            f"groups and seeds (at most {MOST_SEEDS}); band: 95 % interval over seeds. All begin at the same place."
        )
        panel = [("Distance to the other groups' runs (cells)", apart)]
        drawn = partial(curves_figure, panel, Scale(0.0), "Step")
        pictures.append(Picture("divergence", "How far models go apart", caption, drawn, data=panel))
    return pictures
