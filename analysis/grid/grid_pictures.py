"""The plots of 2D worlds, with captions."""

from collections.abc import Sequence
from functools import partial

from msgspec.structs import replace

from analysis.figures.shown import ShownGroup, example_caption
from analysis.form import RunTable
from analysis.grid.grid_figures import COURSES, MOST_SEEDS, GridGroup, Ways, cascade_tree, divergence
from analysis.grid.grid_run import GridRun
from analysis.grid.plots import grid_plots
from analysis.grid.plots.grid_plots import CascadeTree
from analysis.plots import Picture
from analysis.plots.panel import Scale
from analysis.plots.rounds import curves_figure


class GridFigures:
    """Collects the plot data of the runs of all groups: positions, spread of news, paths."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._groups: dict[ShownGroup, GridGroup] = {}

    def add(self, shown: ShownGroup, run: GridRun, seed: int) -> None:
        """Add a run of a group."""
        world = replace(run.world, places=(), fires=()) if run.world.draw_positions else run.world
        self._groups.setdefault(shown, GridGroup(shown, self._seed, world)).add(run, seed)

    def pictures(self, order: Sequence[ShownGroup]) -> list[Picture]:
        """Return the plots, with the groups in the given order."""
        groups = [self._groups[shown] for shown in order if shown in self._groups]
        return [*_of_all_runs(groups), *self._of_single_runs(order)]

    def tables(self, order: Sequence[ShownGroup]) -> list[RunTable]:
        """Return a table of each agent's first warning in the example runs; no table if there was no warning."""
        rows = tuple(
            (tree.run, tree.shown.label, str(edge.step), str(edge.sender), str(edge.recipient))
            for tree in self._trees(order)
            for edge in tree.edges
        )
        caption = f"First warnings in the runs with seed {self._seed}, as recorded in messages.jsonl."
        title, columns = "First warnings, step by step", ("run", "group", "step", "sender", "recipient")
        return [RunTable(title, caption, columns, rows, labels=2)] if rows else []

    def _examples(self, order: Sequence[ShownGroup]) -> list[tuple[ShownGroup, GridRun]]:
        examples = ((shown, self._groups[shown].example) for shown in order if shown in self._groups)
        return [(shown, run) for shown, run in examples if run is not None]

    def _trees(self, order: Sequence[ShownGroup]) -> list[CascadeTree]:
        """Return, for each example run, who first warned whom; nothing if no agent perceives a fire in any run."""
        examples = self._examples(order)
        alarmed = any(run.perceived.any() for _, run in examples)
        return [cascade_tree(run, shown) for shown, run in examples] if alarmed else []

    def _of_single_runs(self, order: Sequence[ShownGroup]) -> list[Picture]:
        fixed, pictures = example_caption(self._seed), []
        trees = self._trees(order)
        if trees:
            caption = (
                f"{fixed} Each dot is an agent, at the step in which it learnt of a fire. A filled dot is an agent "
                "that saw a fire. A hollow dot is an agent that was warned by another. A cross is an agent that warned "
                "others before it learnt of any fire. Each line leads from an agent to one that it was the first to "
                "warn."
            )
            drawn = partial(grid_plots.cascade_figure, trees)
            warnings = [(tree.shown.label, tree.edges) for tree in trees]
            pictures.append(Picture("cascade", "Who warned whom", caption, drawn, data=warnings))
        examples = self._examples(order)
        if examples:
            caption = f"{fixed} One line per agent, from its start (dot) to its end (ring)."
            drawn = partial(grid_plots.paths_figure, examples)
            ways = [Ways(shown, run.x, run.y) for shown, run in examples]
            pictures.append(Picture("paths", "Paths of the agents", caption, drawn, data=ways))
        return pictures


def _of_all_runs(groups: Sequence[GridGroup]) -> list[Picture]:
    pictures = []
    maps = [group.occupancy_map() for group in groups]
    if maps:
        caption = (
            "How much of the time agents spend in each cell: its share of all agent-steps after the start, as mean "
            "over the complete runs. All maps have the same colour scale. The scale ends at the 95th percentile of "
            "the visited cells, so that a single crowded cell does not hide the others. Outlines are places. Crosses "
            "are fires, and dashed rings show how far fires can be perceived. If the places or fires of the runs "
            "differ, the map shows none of them."
        )
        pictures.append(
            Picture(
                "occupancy", "Positions of the agents", caption, partial(grid_plots.occupancy_figure, maps), data=maps
            )
        )
    curves = [curve for curve in (group.survival_curve() for group in groups) if curve is not None]
    if curves:
        caption = (
            "Share of agents that no warning has reached yet (Kaplan-Meier estimate for each run). Line: mean over "
            "runs; band: 95 % interval over runs, not agents. An agent that sees a fire before any warning is "
            "censored. Runs in which no agent perceives a fire are left out."
        )
        # The name of a plot is a signature's name; `survival` belongs to worlds with energy.
        name = "not_warned" if any(group.world.energy for group in groups) else "survival"
        pictures.append(
            Picture(
                name, "Time to the first warning", caption, partial(grid_plots.survival_figure, curves), data=curves
            )
        )
    present = [curve for curve in (group.presence_curve() for group in groups) if curve is not None]
    if present:
        caption = (
            "Share of the initial agents that have neither left nor died, by step. Line: mean over runs; band: 95 % "
            "interval over runs, not agents."
        )
        drawn = partial(grid_plots.survival_figure, present, "Still present (share)")
        pictures.append(Picture("presence", "Agents still present", caption, drawn, data=present))
    return [*pictures, *_by_step(groups)]


def _by_step(groups: Sequence[GridGroup]) -> list[Picture]:
    """Return the plots by step: the agents' behaviour, and how far the agents of different groups are apart."""
    pictures = []
    panels = [(title, [group.course(title) for group in groups]) for title in COURSES]
    caption = "Share of the agents by step. Line: mean over runs; band: 95 % interval over runs, not agents."
    shares = partial(curves_figure, panels, Scale(0.0, 1.0), "Step")
    pictures.append(Picture("course", "Agents' behaviour by step", caption, shares, data=panels))
    apart = divergence(groups)
    if apart:
        caption = (
            "Runs with the same seed begin in the same state. The line shows how far an agent of this group is from "
            "the same agent in the runs of the other groups with the same seed, as mean over agents, groups and seeds "
            f"(at most {MOST_SEEDS} seeds). Band: 95 % interval over seeds."
        )
        panel = [("Distance to the other groups' runs (cells)", apart)]
        drawn = partial(curves_figure, panel, Scale(0.0), "Step")
        pictures.append(Picture("divergence", "Divergence of the models", caption, drawn, data=panel))
    return pictures
