"""The overview shows the scene, the agent, its way, what it sees and what it did."""

from typing import Any

import numpy as np
import pytest

from foundry.worlds.camera.eye.overview import (
    ABOVE_DEG,
    OverviewFrame,
    draw_overview,
)
from foundry.worlds.camera.loading.scene import Scene

FOOT = np.array([0.5, 0.5, 0.0])
TRAIL = np.array([[-1.5, -1.5, 0], [-0.5, -1.5, 0], [-0.5, -1.5, 0], [0.5, 0.5, 0]])


def overview(room: Scene, **changes: Any) -> Any:
    frame = {"foot": FOOT, "yaw_deg": 30.0} | changes
    return draw_overview(room, OverviewFrame(**frame))


def reddish(image: Any) -> Any:
    red, green, blue = np.moveaxis(image.astype(int), 2, 0)
    return (red > 90) & (red > 2 * green) & (red > 2 * blue)


def orange(image: Any) -> Any:
    red, green, blue = np.moveaxis(image.astype(int), 2, 0)
    return (red > 140) & (green > 0.3 * red) & (green < 0.8 * red) & (blue < 0.55 * red)


def test_the_agent_is_a_red_person_seen_through_the_walls_and_drawn_where_it_stands(room: Scene) -> None:
    image = overview(room)
    rows, columns = np.nonzero(reddish(image))
    assert image.shape == (720, 960, 3)
    assert len(rows) > 500
    assert np.ptp(rows) > np.ptp(columns)
    above = [overview(room, foot=np.array([x, 0.0, 0.0]), elevation_deg=90.0) for x in (-1.5, 1.5)]
    left, right = (np.nonzero(reddish(one))[1].mean() for one in above)
    assert right - left > 100


def test_the_way_so_far_is_drawn_and_nothing_of_one_frame_stays_in_the_next(room: Scene) -> None:
    alone = overview(room)
    assert orange(alone).sum() == 0 and orange(overview(room, trail=TRAIL)).sum() > 200
    overview(room, trail=TRAIL, caption="step 2", height_m=1.2, elevation_deg=ABOVE_DEG)
    assert np.array_equal(overview(room), alone)
    near = overview(room, bounds=np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 2.0]]))
    assert reddish(near).sum() > 3 * reddish(alone).sum()


@pytest.mark.parametrize(("elevation", "shape"), [(32.0, (384, 512)), (60.0, (512, 384)), (ABOVE_DEG, (200, 800))])
def test_the_inset_hides_nothing_of_the_scene(room: Scene, elevation: float, shape: tuple[int, int]) -> None:
    """All around the inset is paper, and the whole way is seen."""
    view = np.full((*shape, 3), (0, 0, 200), np.uint8)
    corners = np.array([[x, y, 0] for x, y in ((-2, -2), (2, -2), (2, 2), (-2, 2))])
    frame = {"trail": corners, "elevation_deg": elevation}
    image, alone = overview(room, inset=view, **frame), overview(room, **frame)
    rows, columns = np.nonzero((image == [0, 0, 200]).all(axis=2))
    around = image[max(rows.min() - 8, 0) : rows.max() + 9, max(columns.min() - 8, 0) : columns.max() + 9].astype(int)
    paper = np.abs(around - alone[-1, -1]).max(axis=2) <= 3
    assert len(rows) > 288 * 70 and paper[[0, -1]].all() and paper[:, [0, -1]].all()
    assert orange(image).sum() > 0.4 * orange(alone).sum()
    assert (np.abs(image[:, [0, -1]].astype(int) - alone[-1, -1]).max(axis=2) <= 3).all()
