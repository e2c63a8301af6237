"""The scenes that ship with foundry: whole, labelled, of the size they claim, and made by the script beside them."""

import re
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import lru_cache
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from pxr import Kind, Sdf, Usd, UsdGeom, UsdSemantics

from foundry.paths import assets_dir
from foundry.worlds.camera.body.collision import Body, Collider
from foundry.worlds.camera.body.navigation import Navigator
from foundry.worlds.camera.loading.stage import load_scene

SCENES = ("kibo", "office", "gallery")
BODY = Body(0.3, 1.75, 0.25)


@dataclass(frozen=True)
class Expected:
    """What the README says: inner bounds (x0, y0, x1, y1), floor height, a start, and the outer bounds; metres."""

    inside: tuple[float, float, float, float]
    floor: float
    start: tuple[float, float]
    low: tuple[float, float, float]
    high: tuple[float, float, float]


EXPECTED = {
    "kibo": Expected((-5.2, 19.0, 5.8, 21.2), -0.2358, (4.0, 20.1), (-5.3, 17.9, -1.3358), (5.9, 22.3, 3.0642)),
    "office": Expected((0, 0, 14, 10), 0.0, (7.0, 5.0), (-0.16, -0.16, -0.1), (14.16, 10.16, 2.7)),
    "gallery": Expected((0, 0, 16, 12), 0.0, (4.0, 1.6), (-0.16, -0.16, -0.1), (16.16, 12.16, 3.1)),
}


@lru_cache
def opened(scene: str) -> Usd.Stage:
    return Usd.Stage.Open(str(assets_dir() / f"{scene}.usdz"))


def prims(scene: str) -> Iterator[Usd.Prim]:
    yield from Usd.PrimRange(opened(scene).GetPseudoRoot(), Usd.TraverseInstanceProxies())


@lru_cache
def faces_by_prim(scene: str) -> dict[str, NDArray[np.float64]]:
    """The (faces, 2, 3) bounding boxes of the faces of each mesh, world space, metres."""
    cache, boxes = UsdGeom.XformCache(), {}
    for prim in prims(scene):
        if not prim.IsA(UsdGeom.Mesh):
            continue
        mesh = UsdGeom.Mesh(prim)
        matrix = np.array(cache.GetLocalToWorldTransform(prim))
        points = np.array(mesh.GetPointsAttr().Get(), dtype=float) @ matrix[:3, :3] + matrix[3, :3]
        corners = points[np.array(mesh.GetFaceVertexIndicesAttr().Get())]
        starts = np.concatenate([[0], np.cumsum(mesh.GetFaceVertexCountsAttr().Get())[:-1]])
        low, high = np.minimum.reduceat(corners, starts), np.maximum.reduceat(corners, starts)
        boxes[str(prim.GetPath())] = np.stack([low, high], axis=1)
    return boxes


def targets(scene: str) -> list[tuple[str, str, float]]:
    """Name, prim pattern and radius of each target that the README suggests."""
    section = re.split(r"^## ", (assets_dir() / "README.md").read_text(encoding="utf-8"), flags=re.M)
    (own,) = [text for text in section if text.startswith(scene + "\n")]
    return [
        (name, prim, float(radius))
        for name, prim, radius in re.findall(r"^\| (.+?) \| `(.+?)` \| ([\d.]+) \|", own, re.M)
    ]


def labels(prim: Usd.Prim) -> list[str]:
    if not prim.HasAPI(UsdSemantics.LabelsAPI, "foundry"):
        return []
    return list(UsdSemantics.LabelsAPI(prim, "foundry").GetLabelsAttr().Get())


def matching(scene: str, pattern: str) -> list[Usd.Prim]:
    return [prim for prim in prims(scene) if labels(prim) and fnmatchcase(str(prim.GetPath()), pattern)]


@pytest.mark.parametrize("scene", SCENES)
def test_a_scene_opens_without_errors_and_has_the_bounds_it_claims_instances_parts_and_textures(scene: str) -> None:
    stage = opened(scene)
    assert stage.GetCompositionErrors() == []
    assert str(stage.GetDefaultPrim().GetPath()) == "/World"
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    boxes = np.concatenate(list(faces_by_prim(scene).values()))
    np.testing.assert_allclose(boxes[:, 0].min(0), EXPECTED[scene].low, atol=1e-3)
    np.testing.assert_allclose(boxes[:, 1].max(0), EXPECTED[scene].high, atol=1e-3)
    assert any(prim.IsInstance() for prim in prims(scene))
    assert any(prim.IsA(UsdGeom.Subset) for prim in prims(scene))


@pytest.mark.parametrize("scene", SCENES)
def test_every_texture_a_scene_names_is_in_its_package_aligned_and_not_compressed(scene: str) -> None:
    files = set(zipfile.ZipFile(assets_dir() / f"{scene}.usdz").namelist())
    named = {
        value.path
        for prim in prims(scene)
        for attribute in prim.GetAttributes()
        if isinstance(value := attribute.Get(), Sdf.AssetPath)
    }
    assert named
    assert {f"{scene}.usdc", *named} == files
    package = (assets_dir() / f"{scene}.usdz").read_bytes()
    with zipfile.ZipFile(BytesIO(package)) as opened_package:
        for entry in opened_package.infolist():
            name, extra = (int.from_bytes(package[entry.header_offset + at :][:2], "little") for at in (26, 28))
            assert entry.compress_type == zipfile.ZIP_STORED
            assert (entry.header_offset + 30 + name + extra) % 64 == 0


@pytest.mark.parametrize("scene", SCENES)
def test_everything_that_can_be_asked_for_has_a_label_and_beside_it_only_the_walls(scene: str) -> None:
    things = [prim for prim in prims(scene) if Usd.ModelAPI(prim).GetKind() == Kind.Tokens.component]
    assert things == [prim for prim in prims(scene) if labels(prim) not in ([], ["wall"])]
    for thing in things:
        assert Usd.ModelAPI(thing).GetAssetName() == labels(thing)[0]
        assert any(path.startswith(f"{thing.GetPath()}/") for path in faces_by_prim(scene))


@pytest.mark.parametrize(("scene", "least"), [("kibo", 6), ("office", 6), ("gallery", 12)])
def test_the_suggested_targets_exist_under_their_names(scene: str, least: int) -> None:
    suggested = targets(scene)
    assert len(suggested) >= least
    for name, pattern, _ in suggested:
        found = matching(scene, pattern)
        assert found, pattern
        assert all(name in labels(prim) for prim in found), pattern


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
def test_one_can_walk_close_enough_to_every_target_but_not_out_of_the_scene(scene: str) -> None:
    expected = EXPECTED[scene]
    ways = Navigator(Collider(load_scene(assets_dir() / f"{scene}.usdz")), BODY)
    places = ways.places[ways.reachable(np.array([*expected.start, expected.floor]))]
    x0, y0, x1, y1 = expected.inside
    assert (places[:, :2] > (x0, y0)).all() and (places[:, :2] < (x1, y1)).all()
    assert places[:, 2] == pytest.approx(expected.floor, abs=1e-3)
    for name, pattern, radius in targets(scene):
        for prim in matching(scene, pattern):
            assert ways.target([str(prim.GetPath())]).is_near(places, radius - 0.2).any(), name


def test_all_assets_together_are_small() -> None:
    assert sum(file.stat().st_size for file in assets_dir().rglob("*") if file.is_file()) < 3_000_000


@pytest.fixture(scope="module")
def rebuilt(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scenes")
    script = assets_dir() / "make_scenes.py"
    subprocess.run([sys.executable, "-B", str(script), "--out", str(folder)], check=True)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
def test_the_script_makes_the_shipped_scene(scene: str, rebuilt: Path) -> None:
    # Compared by content: other versions of zlib, FreeType or usd-core may write other bytes.
    shipped, made = (Usd.Stage.Open(str(f / f"{scene}.usdz")) for f in (assets_dir(), rebuilt))
    assert made.GetRootLayer().ExportToString() == shipped.GetRootLayer().ExportToString()
    with zipfile.ZipFile(assets_dir() / f"{scene}.usdz") as old, zipfile.ZipFile(rebuilt / f"{scene}.usdz") as new:
        assert new.namelist() == old.namelist()
        for name in new.namelist()[1:]:
            before, after = (np.asarray(Image.open(BytesIO(p.read(name))), dtype=float) for p in (old, new))
            assert before.shape == after.shape, name
            assert np.abs(before - after).mean() < 2, name


@pytest.mark.exhaustive
def test_the_script_writes_the_same_bytes_again(rebuilt: Path, tmp_path: Path) -> None:
    script = assets_dir() / "make_scenes.py"
    subprocess.run([sys.executable, "-B", str(script), "--out", str(tmp_path), "kibo"], check=True)
    assert (tmp_path / "kibo.usdz").read_bytes() == (rebuilt / "kibo.usdz").read_bytes()


@pytest.mark.slow
def test_the_script_names_the_scenes_it_knows(tmp_path: Path) -> None:
    script = assets_dir() / "make_scenes.py"
    asked = [sys.executable, "-B", str(script), "--out", str(tmp_path), "kibu"]
    result = subprocess.run(asked, check=False, capture_output=True, text=True)
    assert result.returncode == 2
    assert "scene 'kibu' not found. Available: kibo, office, gallery." in result.stderr
