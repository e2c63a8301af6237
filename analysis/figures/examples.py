"""Reads every complete run once and keeps what is shown of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from analysis.camera_run import CameraRun
from analysis.figures.camera import top_downs
from analysis.figures.grid import GridGroup, cascade_tree, grid_paths
from analysis.figures.shown import Member, Shown
from analysis.labelling import Labelling
from analysis.load import is_measurable, read_records, read_run
from analysis.plots.cascade import CascadeTree
from analysis.plots.occupancy import GridPaths, OccupancyMap
from analysis.plots.survival import SurvivalCurve
from analysis.plots.topdown import TopDown
from analysis.run import GridRun


@dataclass(frozen=True)
class Examples:
    """What is shown of the runs themselves.

    Attributes:
        seed: the lowest seed, whose runs are shown one by one.
        maps: where agents were, by group of a 2D world.
        curves: how many agents are not warned yet.
        trees: who warned whom in the run of the seed.
        paths: the ways in that run.
        top_downs: the ways in the runs of that seed in 3D worlds.
        doubts: the first decision that could not be read, step and agent, by run.
    """

    seed: int
    maps: tuple[OccupancyMap, ...] = ()
    curves: tuple[SurvivalCurve, ...] = ()
    trees: tuple[CascadeTree, ...] = ()
    paths: tuple[GridPaths, ...] = ()
    top_downs: tuple[TopDown, ...] = ()
    doubts: Mapping[str, tuple[int, int]] = field(default_factory=dict)


def examples(found: Sequence[Member], shown: Sequence[Shown], labellings: Mapping[str, Labelling]) -> Examples:
    """Read the complete runs.

    Args:
        found: the runs.
        shown: their groups, in order.
        labellings: who says which messages are warnings, by run.

    Raises:
        RecordError: a recorded file is damaged.
    """
    seed = min(member.seed for member in found)
    groups: dict[Shown, GridGroup] = {}
    cameras: dict[Shown, CameraRun] = {}
    doubts: dict[str, tuple[int, int]] = {}
    for member in found:
        if member.complete and is_measurable(member.folder, member.summary):
            run = read_run(member.folder, read_records(member.folder, member.summary))
            run = labellings[member.folder.id].label(run)
            if not run.readable.all():
                doubts[run.id] = _first_doubt(run)
            if isinstance(run, GridRun):
                groups.setdefault(member.shown, GridGroup(member.shown, seed, run.world)).add(run, member.seed)
            elif member.seed == seed:
                cameras.setdefault(member.shown, run)
    kept = [groups[one] for one in shown if one in groups]
    return replace(_examples(seed, kept, [(one, cameras[one]) for one in shown if one in cameras]), doubts=doubts)


def _first_doubt(run: GridRun | CameraRun) -> tuple[int, int]:
    """Return step and agent of the first decision that could not be read."""
    step, *agent = np.argwhere(~run.readable)[0].tolist()
    return step + 1, agent[0] if agent else 0


def _examples(seed: int, groups: Sequence[GridGroup], cameras: Sequence[tuple[Shown, CameraRun]]) -> Examples:
    curves = (group.survival_curve() for group in groups)
    kept = [(group.shown, group.example) for group in groups if group.example is not None]
    alarmed = any(run.perceived.any() for _, run in kept)
    return Examples(
        seed=seed,
        maps=tuple(group.occupancy_map() for group in groups),
        curves=tuple(curve for curve in curves if curve is not None),
        trees=tuple(cascade_tree(run, shown) for shown, run in kept) if alarmed else (),
        paths=tuple(grid_paths(run, shown) for shown, run in kept),
        top_downs=tuple(top_downs(cameras)),
    )
