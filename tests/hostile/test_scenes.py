"""A scene reads only below its own folder, unless another is named; what it names elsewhere is not read."""

import os
import zipfile
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf

from commands import refusal, succeeds
from foundry.errors import InputError
from foundry.worlds.camera.loading import scene_files
from foundry.worlds.camera.loading.stage import load_scene
from worlds.camera.usd_files import bind, mesh, picture, texture_coordinates, textured, write_stage

HEAD = '#usda 1.0\n(upAxis = "Z"\nmetersPerUnit = 1\n{})\n'
OWN = """def Mesh "Floor"
{
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
}
"""
ARCS = {
    "reference": ("", 'def "A" (references = @{}@</Tile>) {{}}\n'),
    "payload": ("", 'def "A" (payload = @{}@</Tile>) {{}}\n'),
    "sublayer": ("subLayers = [@{}@]\n", ""),
    "variant": ("", 'def "A" (variants = {{\n string v = "x"\n}}\nprepend variantSets = "v") {{\n'
                    'variantSet "v" = {{\n"x" (references = @{}@</Tile>) {{\n}}\n}}\n}}\n'),
    "nested": ("", 'def "A" {{\n def "B" (prepend references = [@{}@</Tile>]) {{\n}}\n}}\n'),
}  # fmt: skip


@pytest.fixture
def place(tmp_path: Path) -> Path:
    (tmp_path / "scene").mkdir()
    write_stage(tmp_path / "secret.usda", lambda stage: mesh(stage, "/Tile"))
    picture(tmp_path / "secret.png", np.zeros((4, 4, 3)))
    return tmp_path / "scene"


def scene(place: Path, arc: str, target: str) -> Path:
    head, body = ARCS[arc]
    file = place / "scene.usda"
    file.write_text(HEAD.format(head.format(target)) + OWN + body.format(target))
    return file


@pytest.mark.parametrize("arc", ARCS)
@pytest.mark.parametrize("absolute", [False, True])
def test_a_layer_elsewhere_is_refused_and_read_only_below_a_named_folder(arc: str, absolute: bool, place: Path):
    file = scene(place, arc, str(place.parent / "secret.usda") if absolute else "../secret.usda")
    with pytest.raises(
        InputError, match=r"refers to '.*secret\.usda', which is not below '.*scene'.*world\.scene\.root"
    ):
        load_scene(file)
    assert len(load_scene(file, root=place.parent).meshes) == 2


def test_a_system_file_is_refused_without_advice_that_opens_the_whole_disk_and_a_missing_one_is_named(place: Path):
    with pytest.raises(InputError, match="refers to '/etc/passwd'"):
        load_scene(scene(place, "reference", "/etc/passwd"))
    found = load_scene(scene(place, "reference", "../../nowhere/x.usda"))
    assert any("nowhere" in warning for warning in found.warnings)
    with pytest.raises(InputError, match="Copy them into one folder"):
        load_scene(scene(place, "reference", "/etc/passwd"))


def test_a_layer_of_a_layer_and_a_link_are_refused(place: Path):
    (place / "near.usda").write_text(HEAD.format("") + 'def "Tile" (references = @../secret.usda@</Tile>) {}\n')
    with pytest.raises(InputError, match="secret"):
        load_scene(scene(place, "reference", "./near.usda"))
    os.symlink(place.parent / "secret.usda", place / "link.usda")
    with pytest.raises(InputError, match="secret"):
        load_scene(scene(place, "sublayer", "./link.usda"))


def test_a_clip_elsewhere_is_refused_or_not_drawn(place: Path):
    asset = f'asset[] assetPaths = [@{place.parent}/secret.usda@]; string primPath = "/Tile"'
    clips = f"dictionary default = {{ {asset}; double2[] active = [(0, 0)]; double2[] times = [(0, 0)] }}"
    file = place / "scene.usda"
    file.write_text(HEAD.format("") + OWN + f'def Mesh "A" (clips = {{ {clips} }}) {{}}\n')
    try:
        assert [part.path for part in load_scene(file).meshes] == ["/Floor"]
    except InputError as error:
        assert "secret" in str(error)


def test_a_texture_elsewhere_is_named_and_not_read(place: Path):
    def build(stage: object) -> None:
        made = mesh(stage, "/Wall")
        texture_coordinates(made, [(0, 0), (1, 0), (1, 1), (0, 1)])
        bind(made, textured(stage, "/Paint", "../secret.png"))

    file = write_stage(place / "scene.usda", build)
    scene = load_scene(file)
    assert any("Texture outside the scene's folder is not read" in warning for warning in scene.warnings)
    assert all(part.texture is None for part in scene.meshes)
    assert any(part.texture is not None for part in load_scene(file, root=place.parent).meshes)


@pytest.mark.parametrize("name", ["../evil.usda", "/tmp/evil-scene.usda", "..\\evil.usda"])
def test_a_package_with_names_that_lead_elsewhere_writes_nothing(name: str, place: Path):
    with zipfile.ZipFile(place / "scene.usdz", "w", zipfile.ZIP_STORED) as package:
        package.writestr("root.usda", HEAD.format("") + OWN + f'def "A" (references = @{name}@</Tile>) {{}}\n')
        package.writestr(name, HEAD.format("") + 'def Mesh "Tile" {}\n')
    before = sorted(place.parent.rglob("*"))
    try:
        assert len(load_scene(place / "scene.usdz").meshes) == 1
    except InputError as error:
        assert "\n" not in str(error)
    assert sorted(place.parent.rglob("*")) == before and not Path("/tmp/evil-scene.usda").exists()


def test_the_command_line_names_the_way_out(place: Path):
    file = str(scene(place, "reference", "../secret.usda"))
    assert f"--root '{place.parent}'" in refusal("scene", "info", file, cwd=place)
    succeeds("scene", "info", file, "--root", str(place.parent), cwd=place)


MATERIALX = """<?xml version="1.0"?>
<materialx version="1.38" xmlns:xi="http://www.w3.org/2001/XInclude">
  <xi:include href="{}"/>
  <surfacematerial name="Brown" type="material"/>
</materialx>
"""


@pytest.mark.parametrize("include", ["../pipe", "./gone.mtlx"])
def test_a_scene_with_materialx_is_drawn_and_what_that_includes_is_not_read(include: str, place: Path):
    os.mkfifo(place.parent / "pipe")  # whoever reads it waits for ever
    (place / "paint.mtlx").write_text(MATERIALX.format(include))
    found = load_scene(scene(place, "reference", "./paint.mtlx"))
    assert [part.path for part in found.meshes] == ["/Floor"]
    assert any("paint.mtlx" in warning and "composed" in warning for warning in found.warnings)


@pytest.mark.parametrize("target", ["../secret.mtlx", "../secret.abc", "../secret"])
def test_a_file_elsewhere_is_refused_whatever_its_format(target: str, place: Path):
    (place / target).write_text(MATERIALX.format("x"))
    with pytest.raises(InputError, match="refers to '.*secret"):
        load_scene(scene(place, "reference", target))


@pytest.mark.parametrize("arc", ARCS)
@pytest.mark.parametrize("name", ["tile.abc", "tile", "tile.mtlx", "broken.usda", "gone.mtlx"])
def test_a_layer_that_usd_cannot_read_is_named_and_the_rest_is_drawn(arc: str, name: str, place: Path):
    if name != "gone.mtlx":
        (place / name).write_text("#usda 1.0\ndef {")
    found = load_scene(scene(place, arc, f"./{name}"))
    assert [part.path for part in found.meshes] == ["/Floor"]
    assert any(name in warning for warning in found.warnings)


def test_a_format_that_an_extension_of_usd_reads_is_refused(place: Path, monkeypatch: pytest.MonkeyPatch):
    """Such a format may include files of its own; here one of USD's own stands for it."""
    (place / "near.usdc").write_bytes(b"")
    monkeypatch.setattr(scene_files, "FORMATS", ("usda",))
    with pytest.raises(InputError, match=r"An extension of USD reads '\.usdc' files"):
        load_scene(scene(place, "reference", "./near.usdc"))


def test_usd_comes_with_no_format_that_is_not_confined():
    assert set(Sdf.FileFormat.FindAllFileFormatExtensions()) <= set(scene_files.FORMATS)
