from __future__ import annotations

import struct
from dataclasses import replace

from foundry.worlds.grid.grid_drawing import draw, make_frame


def frame_of(scenario, step, cells):
    return make_frame(scenario.settings, scenario.personas(0), step, cells)


def test_a_frame_is_a_png_of_800_pixels_that_names_no_software_also_of_an_empty_world(at):
    png = at((0, 0), (25, 25)).start(0).draw()
    assert png.startswith(b"\x89PNG")
    assert struct.unpack(">II", png[16:24]) == (800, 800)
    assert b"Software" not in png
    world = at((0, 0), places=[], fires=[], personas={}).start(0)
    assert world.draw().startswith(b"\x89PNG")


def test_the_same_frame_gives_the_same_bytes_and_another_does_not(at):
    frame = frame_of(at((0, 0), (0, 0), (3, 3)), 7, [(0, 0), (0, 0), (3, 3)])
    assert draw(frame) == draw(replace(frame))
    assert draw(frame) != draw(replace(frame, fires=()))


def test_a_frame_shows_fires_that_burn_links_and_occupancy(at):
    cells = [(15, 0), (16, 0), (21, 0)]
    scenario = at(*cells)
    frame = frame_of(scenario, 3, cells)
    assert [fire.name for fire in frame.fires] == ["fire1"]
    assert frame.links == ((0, 1),)
    assert frame.occupancy == (0, 2)
    assert frame_of(scenario, 2, cells).fires == ()
