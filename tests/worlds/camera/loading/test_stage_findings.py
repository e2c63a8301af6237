"""What cannot be drawn or resolved is named once, and the rest is drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade, UsdSkel

from foundry.worlds.camera.loading import stage as walking
from foundry.worlds.camera.loading.stage import load_scene
from worlds.camera.usd_files import (
    bind,
    load,
    material,
    mesh,
    picture,
    primvar,
    shader,
    texture_coordinates,
    textured,
    write_stage,
)

NAMES = Sdf.ValueTypeNames
CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))


def square(stage: Any, paint: Any = None) -> Any:
    made = mesh(stage, "/Square")
    texture_coordinates(made, CORNERS)
    if paint:
        bind(made, paint)
    return made


def test_curves_points_and_the_like_are_counted_by_kind(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        square(stage)
        for number in range(8):
            UsdGeom.BasisCurves.Define(stage, f"/Hair{number}")
        UsdGeom.Points.Define(stage, "/Dust")

    scene = load(tmp_path, build)
    assert scene.warnings == (
        "BasisCurves prims are not drawn: /Hair0; /Hair1; /Hair2; /Hair3; /Hair4 and 3 more",
        "Points prims are not drawn: /Dust",
    )
    assert scene.triangles == 2


def test_a_missing_reference_and_a_missing_sublayer_are_named(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    def build(stage: Any) -> None:
        square(stage)
        stage.GetRootLayer().subLayerPaths.append("./gone_layer.usda")
        stage.DefinePrim("/Rack").GetReferences().AddReference("omniverse://server/rack.usd")
        stage.DefinePrim("/Hatch").GetPayloads().AddPayload("./gone_hatch.usd")

    file = write_stage(tmp_path / "scene.usda", build)
    capfd.readouterr()
    scene = load_scene(file)
    text = "\n".join(scene.warnings)
    assert all(name in text for name in ("gone_layer.usda", "server/rack.usd", "gone_hatch.usd"))
    assert scene.triangles == 2
    assert capfd.readouterr().err == ""


def test_a_missing_texture_is_named_and_the_fallback_is_drawn(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        fallback = (NAMES.Float4, Gf.Vec4f(0, 1, 0, 1))
        square(stage, textured(stage, "/Paint", "./gone.png", fallback=fallback))

    scene = load(tmp_path, build)
    assert scene.warnings == ("Texture not found: './gone.png' of /Paint/Picture",)
    assert scene.meshes[0].colour == pytest.approx((0, 1, 0))


def test_a_texture_of_an_unknown_kind_is_named(tmp_path: Path) -> None:
    (tmp_path / "light.exr").write_bytes(b"v/1\x01 and no picture")
    scene = load(tmp_path, lambda stage: square(stage, textured(stage, "/Paint", "./light.exr")))
    assert scene.warnings[0].startswith("Texture of a kind that cannot be read")
    assert scene.meshes[0].texture is None


def test_tiles_of_udim_textures_beyond_the_first_are_named(tmp_path: Path) -> None:
    for tile in (1001, 1002):
        picture(tmp_path / f"skin.{tile}.png", [[[tile % 256, 0, 0]]])
    scene = load(tmp_path, lambda stage: square(stage, textured(stage, "/Paint", "./skin.<UDIM>.png")))
    assert scene.warnings == ("Only the first tile of UDIM textures is drawn: ./skin.<UDIM>.png",)
    assert scene.meshes[0].texture.tolist() == [[[1001 % 256, 0, 0]]]


def test_a_shader_that_is_not_known_leaves_the_display_colour(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        made = square(stage, material(stage, "/Paint", "ND_volume"))
        made.CreateDisplayColorAttr([Gf.Vec3f(1, 0, 0)])

    scene = load(tmp_path, build)
    assert scene.warnings == ("Shaders of the kind 'ND_volume' cannot be drawn: /Paint/Surface",)
    assert scene.meshes[0].colour == pytest.approx((1, 0, 0))


def test_of_materialx_the_base_colour_is_drawn(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        colour = (NAMES.Color3f, Gf.Vec3f(0, 0, 1))
        square(stage, material(stage, "/Paint", "ND_standard_surface_surfaceshader", base_color=colour))

    scene = load(tmp_path, build)
    assert scene.meshes[0].colour == pytest.approx((0, 0, 1))
    assert "only the base colour is drawn" in scene.warnings[0]


def test_a_material_that_is_not_there_is_named(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        made = square(stage)
        UsdShade.MaterialBindingAPI.Apply(made.GetPrim())
        made.GetPrim().CreateRelationship("material:binding").SetTargets([Sdf.Path("/Looks/Gone")])

    assert load(tmp_path, build).warnings == ("Material not found: /Looks/Gone of /Square",)


def test_a_node_between_texture_and_surface_that_is_not_known_is_named(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        mixed = shader(stage, "/Paint/Mix", "ND_mix_color3")
        square(stage, material(stage, "/Paint", diffuseColor=(NAMES.Color3f, mixed, "out")))

    assert load(tmp_path, build).warnings == ("Shader node that cannot be drawn: ND_mix_color3 at /Paint/Mix",)


def test_a_mesh_whose_faces_name_points_that_are_not_there_is_left_out(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        square(stage)
        mesh(stage, "/Broken", faces=[(0, 1, 9)])
        mesh(stage, "/Short", faceVertexCounts=[4, 4])
        mesh(stage, "/Endless", [(0, 0, 0), (1, 0, 0), (0, float("inf"), 0)], [(0, 1, 2)])
        mesh(stage, "/Empty", [], [])

    scene = load(tmp_path, build)
    assert scene.warnings == ("Mesh whose points and faces do not fit together: /Broken; /Short; /Endless",)
    assert [found.path for found in scene.meshes] == ["/Square"]


def test_values_that_are_too_few_are_left_out(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        made = mesh(stage, "/Square")
        primvar(made, "displayColor", NAMES.Color3fArray, "vertex", [Gf.Vec3f(1, 0, 0)] * 2)

    scene = load(tmp_path, build)
    assert scene.warnings == ("Values that do not fit the faces they are for: /Square.primvars:displayColor",)
    assert scene.meshes[0].colour == (0.7, 0.7, 0.7)


def test_lights_skins_draw_modes_and_unknown_types_are_named(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        UsdSkel.BindingAPI.Apply(square(stage).GetPrim())
        UsdLux.DomeLight.Define(stage, "/Sky")
        stage.DefinePrim("/Fog", "MagicFog")
        house = UsdGeom.Xform.Define(stage, "/House").GetPrim()
        UsdGeom.ModelAPI.Apply(house).CreateModelDrawModeAttr("cards")

    assert load(tmp_path, build).warnings == (
        "Skinned meshes are drawn in their rest shape: /Square",
        "Lights are not used, the scene is lit evenly: /Sky",
        "Prims of the unknown type 'MagicFog' are not drawn: /Fog",
        "Draw mode 'cards' is not drawn, the geometry is: /House",
    )


def test_subdivision_normal_maps_and_displacement_are_named(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        bumps = shader(stage, "/Bumps", "UsdUVTexture", file=(NAMES.Asset, "bumps.png"))
        bumpy = {"normal": (NAMES.Normal3f, bumps, "rgb"), "displacement": (NAMES.Float, bumps, "r")}
        made = square(stage, material(stage, "/Plaster", **bumpy))
        made.GetSubdivisionSchemeAttr().Set("catmullClark")

    assert load(tmp_path, build).warnings == (
        "Subdivision surfaces are drawn without their subdivision: /Square",
        "Normal maps are not drawn: /Plaster/Surface",
        "Displacement is not drawn: /Plaster/Surface",
    )


def test_copies_beyond_the_limit_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(walking, "LARGEST_INSTANCER", 6)

    def build(stage: Any) -> None:
        made = UsdGeom.PointInstancer.Define(stage, "/Grass")
        mesh(stage, "/Grass/Blade")
        made.CreatePrototypesRel().SetTargets([Sdf.Path("/Grass/Blade"), Sdf.Path("/Grass/Gone")])
        made.CreateProtoIndicesAttr([0] * 5 + [1])
        made.CreatePositionsAttr([Gf.Vec3f(number, 0, 0) for number in range(6)])

    scene = load(tmp_path, build)
    assert scene.triangles == 6
    assert scene.warnings == (
        "Only the first 3 of 5 copies are drawn: /Grass/Blade",
        "Prototype not found: /Grass/Gone of /Grass",
    )


def test_a_scene_of_isaac_loads_although_most_of_it_resolves_nowhere(tmp_path: Path) -> None:
    (tmp_path / "isaac.usda").write_text(ISAAC, encoding="utf-8")
    scene = load_scene(tmp_path / "isaac.usda")
    assert scene.bounds.ravel() == pytest.approx([0, 0, 0, 1, 1, 0])
    assert scene.meshes[0].colour == pytest.approx((1, 0, 0), abs=1e-3)
    assert len(scene.warnings) >= 2


ISAAC = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
    subLayers = [@omniverse://nowhere/base.usd@]
)
def Xform "World"
{
    def Mesh "Panel" (prepend apiSchemas = ["MaterialBindingAPI"])
    {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0)]
        rel material:binding = </World/Looks/Paint>
        double3 xformOp:scale:unitsResolve = (0.01, 0.01, 0.01)
        uniform token[] xformOpOrder = ["xformOp:scale:unitsResolve"]
    }
    def Scope "Looks"
    {
        def Material "Paint"
        {
            token outputs:mdl:surface.connect = </World/Looks/Paint/Shader.outputs:out>
            def Shader "Shader"
            {
                uniform token info:implementationSource = "sourceAsset"
                uniform asset info:mdl:sourceAsset = @OmniPBR.mdl@
                uniform token info:mdl:sourceAsset:subIdentifier = "OmniPBR"
                color3f inputs:diffuse_color_constant = (1, 0, 0)
                asset inputs:diffuse_texture = @omniverse://nowhere/panel.png@
                token outputs:out
            }
        }
    }
}
"""
