"""The command line in 3D worlds, the images that models are sent included."""

import base64
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from pxr import UsdGeom

from commands import foundry, refusal, succeeds
from foundry import paths
from foundry.cli import run
from foundry.storing.store import SweepFolder
from ollama_cases import Body
from ollama_server import OllamaServer
from worlds.camera.usd_files import write_stage

CAPTION_PX = 40

SHORT = ("world.steps=2", "analyze=false", "runner.workers=1", "output.dir=out")
SMALL_PICTURES = ("world=kibo_paper", "model=qwen2.5vl:3b", "world.camera.width=96", "world.camera.height=72", *SHORT)


def answer(body: Body) -> str:
    return "I see racks. Move forward 0.5 m."


@pytest.mark.slow
def test_images_go_to_ollama_as_base64_and_no_model_that_cannot_see_is_asked(workspace: Path):
    with OllamaServer(answer) as server:
        succeeds(*SMALL_PICTURES, cwd=workspace, OLLAMA_HOST=server.url)
    (only,) = SweepFolder.open(workspace / "out").runs()
    first, second = server.bodies
    (message,) = first["messages"]
    assert message["content"].endswith("What is your next single movement?")
    assert "Your current pose: position (4.00, 20.10) m, heading 180 deg, gaze +0 deg." in message["content"]
    sent = base64.b64decode(message["images"][0], validate=True)
    assert sent == (only.path / "images" / "step_0001.png").read_bytes()
    assert 'you said "I see racks. Move forward 0.5 m."' in second["messages"][0]["content"]
    assert (first["options"]["num_ctx"], first["think"], first["truncate"]) == (10240, False, False)
    logged = next(only.calls()).messages[0]
    assert "images" not in logged and len(logged["images_sha256"][0]) == 64
    jpeg = ("world.image_format=jpeg", "world.steps=1", "output.dir=jpeg")
    with OllamaServer(answer) as server:
        succeeds(*SMALL_PICTURES, *jpeg, cwd=workspace, OLLAMA_HOST=server.url)
    sent = base64.b64decode(server.bodies[0]["messages"][0]["images"][0])
    (only,) = SweepFolder.open(workspace / "jpeg").runs()
    assert sent[:3] == b"\xff\xd8\xff" and sent == (only.path / "images" / "step_0001.jpg").read_bytes()
    with OllamaServer(answer) as server:
        line = refusal(*SMALL_PICTURES, "model=qwen3:4b", "output.dir=blind", cwd=workspace, OLLAMA_HOST=server.url)
    assert "'qwen3:4b' cannot see images" in line and server.bodies == []


def test_a_policy_is_refused_in_a_world_that_asks_something_else(workspace: Path, capsys: pytest.CaptureFixture[str]):
    assert run(["model=scripted/spin", *SHORT]) == 2
    assert "the world also asks message, action" in capsys.readouterr().err
    assert run(["world=bar", "model=scripted/conditional", *SHORT]) == 2
    assert "the world also asks evening" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("reply", "expected"),
    [
        ("move forward 2 m", {"translate": {"bearing": 0.0, "distance": 2.0}, "turn": None, "stay": False}),
        ("Turn right 30 degrees.", {"translate": None, "turn": -30.0, "gaze": None}),
        ("The wall is grey.", {"translate": None, "turn": None, "gaze": None, "outcome": "unreadable"}),
        ("move forward 9 m", {"translate": {"bearing": 0.0, "distance": 9.0}}),
    ],
)
def test_scene_read_prints_one_object(reply: str, expected: dict[str, object], capsys: pytest.CaptureFixture[str]):
    assert run(["scene", "read", reply]) == 0
    said = json.loads(capsys.readouterr().out)
    assert set(said) == {"translate", "turn", "gaze", "stay", "outcome", "notes"}
    assert expected.items() <= said.items()


def test_scene_read_reads_a_json_string_a_line_and_clamps_with_limits(
    workspace: Path, monkeypatch: pytest.MonkeyPatch, capsys
):
    monkeypatch.setattr("sys.stdin", io.StringIO('"stay"\n\n"look up 20 degrees\\nnow"\n'))
    assert run(["scene", "read", "-"]) == 0
    first, second = map(json.loads, capsys.readouterr().out.splitlines())
    assert (first["stay"], second["gaze"]) == (True, 20.0)
    monkeypatch.setattr("sys.stdin", io.StringIO("stay\n"))
    assert run(["scene", "read", "-"]) == 2
    assert "Line 1 is not a JSON string" in capsys.readouterr().err
    assert json.loads(foundry("scene", "read", "move forward 9 m", "--limits", cwd=workspace).stdout)["translate"] == {
        "bearing": 0.0,
        "distance": 3.0,
    }


@pytest.mark.parametrize(
    "places", [pytest.param([(0, 0, 0)], marks=pytest.mark.slow), [(0, 0, 0), (10, 0, 0), (0, 3, 40)]]
)
def test_a_picture_from_outside_frames_the_whole_scene(workspace: Path, places: list[tuple[int, int, int]]):
    def build(stage: Any) -> None:
        for number, place in enumerate(places):
            cube = UsdGeom.Cube.Define(stage, f"/Cube{number}")
            cube.CreateSizeAttr(0.1 * len(places) ** 2)
            UsdGeom.XformCommonAPI(cube).SetTranslate(place)

    write_stage(Path("cubes.usda"), build)
    assert run(["scene", "shot", "cubes.usda", "--out", "cubes.png"]) == 0
    picture = np.asarray(Image.open("cubes.png"), np.int64)[CAPTION_PX:]
    paper = picture[0, 0]
    edges = (picture[0], picture[-1], picture[:, 0], picture[:, -1])
    assert all((edge == paper).all() for edge in edges) and (picture != paper).any()
    grey = (np.ptp(picture, axis=2) < 8) & (picture != paper).any(axis=2)
    assert grey.any(), "the body hides no cube"


@pytest.mark.slow
def test_scene_says_what_is_in_a_file_and_takes_a_picture(workspace: Path, capsys: pytest.CaptureFixture[str]):
    kibo = str(paths.assets_dir() / "kibo.usdz")
    assert run(["scene", "info", kibo]) == 0
    out = capsys.readouterr().out
    assert "up axis     Z" in out and "JAXA logo: /World/Emblem" in out
    assert run(["scene", "shot", kibo, "--pose", "4,20.1,1.36,180,0", "--out", "view.png"]) == 0
    assert run(["scene", "shot", kibo, "--out", "outside.png"]) == 0
    assert all(Path(name).read_bytes().startswith(b"\x89PNG") for name in ("view.png", "outside.png"))
    assert run(["scene", "shot", kibo, "--pose", "4,20"]) == 2
    assert "not five numbers" in capsys.readouterr().err
    assert run(["scene", "info", "nowhere.usd"]) == 2
