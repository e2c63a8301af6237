"""The figure of `foundry replay --svg` for 3D runs: their paths from above."""

from collections.abc import Sequence
from dataclasses import replace

from matplotlib.figure import Figure

from analysis.camera.camera_figures import draw_topdown, top_downs
from analysis.camera.camera_run import CameraRun
from analysis.figures.shown import ShownGroup
from analysis.plots.figures import stacked


def sketch(runs: Sequence[tuple[ShownGroup, CameraRun]], steps: Sequence[int] | None) -> Figure:
    """Draw the paths up to the last of these steps, each step marked with its number; None means whole paths."""
    tasks = top_downs(runs)
    figure, panels = stacked([3.0 + 0.15 * (len(task.paths) + 2) for task in tasks])
    for ax, task in zip(panels, tasks, strict=True):
        end = None if steps is None else steps[-1] + 1
        paths = tuple(replace(path, foot=path.foot[:end]) for path in task.paths)
        draw_topdown(ax, replace(task, paths=paths))
        for path in paths:
            for step in (step for step in steps or () if step < len(path.foot)):
                ax.annotate(str(step), path.foot[step], (2, 2), textcoords="offset points", size=6)
    return figure
