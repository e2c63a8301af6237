"""What USD composes is what is loaded: references, payloads, variants, instances, visibility, labels."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSemantics, UsdUtils

from foundry.errors import InputError
from foundry.worlds.camera.loading.stage import load_scene
from worlds.camera.usd_files import facing, load, mesh, write_stage


def paths(scene: Any) -> list[str]:
    return [found.path for found in scene.meshes]


def moved(stage: Any, path: str, *shift: float) -> Any:
    made = UsdGeom.Xform.Define(stage, path)
    made.AddTranslateOp().Set(Gf.Vec3d(*shift))
    return made


def tile(tmp_path: Path, name: str = "tile.usda", points: Any = None) -> str:
    """Write a file with a unit square below /Tile and return its name."""

    def build(stage: Any) -> None:
        UsdGeom.Xform.Define(stage, "/Tile")
        mesh(stage, "/Tile/Face", points) if points else mesh(stage, "/Tile/Face")

    write_stage(tmp_path / name, build)
    return f"./{name}"


def test_transforms_add_up_from_the_root(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        outer = moved(stage, "/Outer", 10, 0, 0)
        outer.AddRotateZOp().Set(90)
        outer.AddScaleOp().Set(Gf.Vec3f(2))
        moved(stage, "/Outer/Inner", 1, 0, 0)
        mesh(stage, "/Outer/Inner/Face")

    assert np.allclose(load(tmp_path, build).bounds, [[8, 2, 0], [10, 4, 0]])


def test_a_scale_that_resolves_units_is_applied(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        scale = mesh(stage, "/Face").AddScaleOp(opSuffix="unitsResolve", precision=UsdGeom.XformOp.PrecisionDouble)
        scale.Set(Gf.Vec3d(0.01))

    assert np.allclose(load(tmp_path, build).bounds, [[0, 0, 0], [0.01, 0.01, 0]])


def test_references_and_payloads_are_loaded(tmp_path: Path) -> None:
    name = tile(tmp_path)

    def build(stage: Any) -> None:
        stage.DefinePrim("/A").GetReferences().AddReference(name)
        moved(stage, "/B", 5, 0, 0).GetPrim().GetPayloads().AddPayload(name)

    scene = load(tmp_path, build)
    assert paths(scene) == ["/A/Face", "/B/Face"]
    assert scene.bounds.tolist() == [[0, 0, 0], [6, 1, 0]]


def test_the_selected_variant_is_loaded(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        choice = UsdGeom.Xform.Define(stage, "/Choice").GetPrim().GetVariantSets().AddVariantSet("size")
        for name, factor in (("small", 1), ("large", 4)):
            choice.AddVariant(name)
            choice.SetVariantSelection(name)
            with choice.GetVariantEditContext():
                mesh(stage, "/Choice/Face", [(factor * x, factor * y, 0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])

    assert load(tmp_path, build).bounds.tolist() == [[0, 0, 0], [4, 4, 0]]


def test_native_instances_are_loaded_each_at_its_place(tmp_path: Path) -> None:
    name = tile(tmp_path)

    def build(stage: Any) -> None:
        for number in range(3):
            prim = moved(stage, f"/Row/Tile{number}", 2 * number, 0, 0).GetPrim()
            prim.GetReferences().AddReference(name)
            prim.SetInstanceable(True)

    scene = load(tmp_path, build)
    assert paths(scene) == ["/Row/Tile0/Face", "/Row/Tile1/Face", "/Row/Tile2/Face"]
    assert [found.points[:, 0].min() for found in scene.meshes] == [0, 2, 4]


def instancer(stage: Any, path: str, prototypes: list[str], indices: list[int], positions: list[Any]) -> Any:
    made = UsdGeom.PointInstancer.Define(stage, path)
    made.CreatePrototypesRel().SetTargets([Sdf.Path(one) for one in prototypes])
    made.CreateProtoIndicesAttr(indices)
    made.CreatePositionsAttr([Gf.Vec3f(*one) for one in positions])
    return made


def test_a_point_instancer_draws_copies_of_its_prototypes_and_not_the_prototypes(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        moved(stage, "/Group", 0, 0, 7)
        made = instancer(stage, "/Group/Trees", ["/Group/Trees/Low", "/Group/Trees/High"], [0, 0, 1, 0], [])
        made.GetPositionsAttr().Set([Gf.Vec3f(10 * number, 0, 0) for number in range(1, 5)])
        made.CreateScalesAttr([Gf.Vec3f(1), Gf.Vec3f(3), Gf.Vec3f(1), Gf.Vec3f(1)])
        made.CreateInvisibleIdsAttr([3])
        mesh(stage, "/Group/Trees/Low/Face")
        mesh(stage, "/Group/Trees/High", [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])

    scene = load(tmp_path, build)
    assert paths(scene) == ["/Group/Trees/Low/Face", "/Group/Trees/High"]
    assert scene.triangles == 3 * 2
    assert scene.bounds.tolist() == [[10, 0, 7], [31, 3, 8]]


def test_instancers_nest_and_take_prototypes_from_elsewhere(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        UsdGeom.Xform.Define(stage, "/World")
        stage.CreateClassPrim("/Library")
        mesh(stage, "/Library/Leaf").AddTranslateOp().Set(Gf.Vec3d(0, 0, 1))
        instancer(stage, "/Library/Row", ["/Library/Leaf"], [0, 0], [(0, 0, 0), (2, 0, 0)])
        instancer(stage, "/World/Field", ["/Library/Row"], [0, 0, 0], [(0, 0, 0), (0, 2, 0), (0, 4, 0)])

    scene = load(tmp_path, build)
    assert paths(scene) == ["/World/Field/Row/Leaf"]
    assert scene.triangles == 2 * 3 * 2
    assert scene.bounds.tolist() == [[0, 0, 1], [3, 5, 1]]


def test_mirrored_copies_keep_their_outside(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        made = instancer(stage, "/I", ["/I/Face"], [0, 0], [(0, 0, 0), (5, 0, 0)])
        made.CreateScalesAttr([Gf.Vec3f(-1, 1, 1), Gf.Vec3f(1)])
        mesh(stage, "/I/Face")

    scene = load(tmp_path, build)
    assert facing(scene) == [[0, 0, 1]]
    assert scene.meshes[0].normals.tolist() == [[0, 0, 1]] * 8


def test_what_is_invisible_inactive_or_for_guidance_is_not_drawn(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        mesh(stage, "/Seen")
        UsdGeom.Xform.Define(stage, "/Hidden").MakeInvisible()
        mesh(stage, "/Hidden/Face")
        mesh(stage, "/Off").GetPrim().SetActive(False)
        for purpose in ("guide", "proxy", "render"):
            UsdGeom.Xform.Define(stage, f"/For_{purpose}").CreatePurposeAttr(purpose)
            mesh(stage, f"/For_{purpose}/Face")

    assert paths(load(tmp_path, build)) == ["/Seen", "/For_render/Face"]


def test_excluded_prims_are_left_out_with_all_below_them(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        mesh(stage, "/World/Room/Wall")
        mesh(stage, "/World/Earth/Ball", [(0, 0, 0), (900, 0, 0), (0, 900, 0)], [(0, 1, 2)])
        mesh(stage, "/World/Earth_Clouds/Ball")

    scene = load(tmp_path, build, exclude=["*/Earth*", "/World/Mars"])
    assert paths(scene) == ["/World/Room/Wall"]
    assert scene.bounds.tolist() == [[0, 0, 0], [1, 1, 0]]
    assert scene.warnings == ("Pattern of `exclude` that matches no prim: /World/Mars",)


@pytest.mark.parametrize("ending", ["usd", "usda", "usdc"])
def test_every_kind_of_file_gives_the_same_meshes(tmp_path: Path, ending: str) -> None:
    scene = load(tmp_path / f"scene.{ending}", lambda stage: mesh(stage, "/Floor"))
    assert (scene.name, scene.triangles, scene.bounds.tolist()) == ("scene", 2, [[0, 0, 0], [1, 1, 0]])


def test_a_package_is_loaded_with_what_it_refers_to(tmp_path: Path) -> None:
    name = tile(tmp_path)
    root = write_stage(tmp_path / "root.usda", lambda stage: stage.DefinePrim("/A").GetReferences().AddReference(name))
    assert UsdUtils.CreateNewUsdzPackage(str(root), str(tmp_path / "all.usdz"))
    assert paths(load_scene(tmp_path / "all.usdz")) == ["/A/Face"]


def test_things_are_labelled_by_semantics_by_isaac_and_by_kind(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        for name in ("Sign", "Rack", "Blue_chair", "Lamp", "Floor"):
            mesh(stage, f"/World/{name}/Face")
        prim = {name: stage.GetPrimAtPath(f"/World/{name}") for name in ("Sign", "Rack", "Blue_chair", "Lamp")}
        UsdSemantics.LabelsAPI.Apply(prim["Sign"], "foundry").CreateLabelsAttr(["JAXA logo", "logo"])
        UsdSemantics.LabelsAPI.Apply(prim["Sign"], "class").CreateLabelsAttr(["sign"])
        isaac = prim["Rack"].CreateAttribute("semantic:Semantics_ab12:params:semanticData", Sdf.ValueTypeNames.String)
        isaac.Set("rack")
        Usd.ModelAPI(prim["Blue_chair"]).SetKind("component")
        Usd.ModelAPI(prim["Lamp"]).SetKind("component")
        prim["Lamp"].SetDisplayName("desk lamp")

    scene = load(tmp_path, build)
    assert scene.labels == {
        "JAXA logo": ("/World/Sign",),
        "rack": ("/World/Rack",),
        "Blue chair": ("/World/Blue_chair",),
        "desk lamp": ("/World/Lamp",),
    }
    assert [found.label for found in scene.meshes] == ["JAXA logo", "rack", "Blue chair", "desk lamp", None]


def test_two_things_may_share_a_label(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        for number in range(2):
            UsdSemantics.LabelsAPI.Apply(mesh(stage, f"/Hatch{number}").GetPrim(), "class").CreateLabelsAttr(["hatch"])

    assert load(tmp_path, build).labels == {"hatch": ("/Hatch0", "/Hatch1")}


def test_a_scene_is_loaded_once_and_again_when_it_or_what_it_refers_to_changed(tmp_path: Path) -> None:
    first = load(tmp_path, lambda stage: mesh(stage, "/Floor"))
    assert load_scene(tmp_path / "scene.usda") is first
    second = load(tmp_path / "other.usda", lambda stage: mesh(stage, "/Floor"))
    third = load(tmp_path / "third.usda", lambda stage: mesh(stage, "/Ground"))
    assert first.sha256 == second.sha256 != third.sha256
    assert load_scene(tmp_path / "third.usda", exclude=["/Nothing"]).sha256 != third.sha256
    digests = []
    for size in (1, 2):
        name = tile(tmp_path, f"tile{size}.usda", [(0, 0, 0), (size, 0, 0), (size, 1, 0), (0, 1, 0)])
        (tmp_path / "tile.usda").write_bytes((tmp_path / name).read_bytes())
        root = tmp_path / f"root{size}.usda"
        text = '#usda 1.0\n(upAxis = "Z"\nmetersPerUnit = 1)\ndef "A" (references = @./tile{}.usda@</Tile>) {{}}\n'
        root.write_text(text.format(size), encoding="utf-8")
        digests.append(load_scene(root).sha256)
    assert digests[0] != digests[1]


def test_a_file_that_is_not_there_names_the_closest_one(tmp_path: Path) -> None:
    write_stage(tmp_path / "kibo.usda", lambda stage: mesh(stage, "/Floor"))
    with pytest.raises(InputError, match=r"Scene '.*kibbo\.usda' not found\. Did you mean '.*kibo\.usda'\?"):
        load_scene(tmp_path / "kibbo.usda")
    with pytest.raises(InputError, match="is no USD scene: its name must end in .usd, .usda, .usdc, .usdz"):
        load_scene(tmp_path / "kibo.obj")


def test_a_broken_file_and_an_empty_stage_are_refused_in_one_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "broken.usda").write_text("#usda 1.0\ndef Mesh {", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be opened as a USD stage") as broken:
        load_scene(tmp_path / "broken.usda")
    with pytest.raises(InputError, match="shows nothing that can be drawn") as empty:
        load(tmp_path / "empty.usda", lambda stage: None)
    assert not re.search(r"\n", f"{broken.value}{empty.value}")
    assert capfd.readouterr().err == ""
