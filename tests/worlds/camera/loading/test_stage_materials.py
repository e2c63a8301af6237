"""Materials give surfaces their colour and pictures; what cannot be drawn is named once, and the rest is drawn."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade, UsdSkel, UsdUtils

from foundry.worlds.camera.loading import stage as walking
from foundry.worlds.camera.loading.stage import load_scene
from worlds.camera.usd_files import (
    bind,
    instancer,
    loaded,
    material,
    mesh,
    one_mesh,
    picture,
    primvar,
    saved,
    shader,
    texture_coordinates,
    textured,
    write_stage,
)

NAMES = Sdf.ValueTypeNames
CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))
FOUR = [[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]]
"""Red and green above blue and white."""


def painted(stage: Any, paint: Any = None, path: str = "/Square") -> Any:
    made = mesh(stage, path)
    texture_coordinates(made, CORNERS)
    if paint:
        bind(made, paint)
    return made


def uv_by_corner(found: Any) -> dict[tuple[float, ...], list[float]]:
    pairs = zip(found.points[:, :2].tolist(), found.uvs.tolist(), strict=True)
    return {tuple(point): np.round(uv, 6).tolist() for point, uv in pairs}


def colour(*values: float) -> Any:
    return NAMES.Color3f, Gf.Vec3f(*values)


def test_a_preview_surface_gives_colour_opacity_and_emission_and_counts_more_than_the_display_colour(
    stage: Any,
) -> None:
    colours = {"diffuseColor": colour(0.2140, 0, 0), "emissiveColor": colour(0, 1, 0)}
    made = painted(stage, material(stage, "/Paint", opacity=(NAMES.Float, 0.5), **colours))
    made.CreateDisplayColorAttr([Gf.Vec3f(0, 0, 1)])
    found = one_mesh(loaded(stage))
    assert found.colour == pytest.approx((0.5, 0, 0), abs=1e-3)
    assert (found.opacity, found.emissive) == (0.5, pytest.approx((0, 1, 0)))


def test_a_colour_may_come_from_the_interface_of_the_material_or_from_a_primvar(stage: Any) -> None:
    paint = material(stage, "/Paint", diffuseColor=colour(0, 0, 0))
    public = paint.CreateInput("tint", NAMES.Color3f)
    public.Set(Gf.Vec3f(0, 1, 0))
    UsdShade.Shader(stage.GetPrimAtPath("/Paint/Surface")).GetInput("diffuseColor").ConnectToSource(public)
    painted(stage, paint)
    reader = shader(stage, "/Read/Reader", "UsdPrimvarReader_float3", varname=(NAMES.String, "paint"))
    made = painted(stage, material(stage, "/Read", diffuseColor=(NAMES.Color3f, reader, "result")), "/Other")
    primvar(made, "paint", NAMES.Color3fArray, "constant", [Gf.Vec3f(1, 0, 1)])
    assert [mesh.colour for mesh in loaded(stage).meshes] == [pytest.approx((0, 1, 0)), pytest.approx((1, 0, 1))]


def test_a_texture_is_read_with_its_coordinates_once_also_out_of_a_package(stage: Any, tmp_path: Path) -> None:
    pixels = picture(tmp_path / "four.png", FOUR)
    painted(stage, textured(stage, "/Paint", "./four.png"))
    painted(stage, textured(stage, "/Again", "./four.png"), "/Other")
    found, other = loaded(stage).meshes
    assert np.array_equal(found.texture, pixels) and other.texture is found.texture
    assert uv_by_corner(found) == {(0, 0): [0, 0], (1, 0): [1, 0], (1, 1): [1, 1], (0, 1): [0, 1]}
    assert (found.colour, found.wrap) == ((1, 1, 1), "repeat")
    root = write_stage(tmp_path / "root.usda", lambda stage: painted(stage, textured(stage, "/Paint", "./four.png")))
    assert UsdUtils.CreateNewUsdzPackage(str(root), str(tmp_path / "all.usdz"))
    assert np.array_equal(one_mesh(load_scene(tmp_path / "all.usdz")).texture, pixels)


def test_texture_coordinates_are_scaled_turned_and_moved(stage: Any, tmp_path: Path) -> None:
    picture(tmp_path / "four.png", FOUR)
    paint = textured(stage, "/Paint", "./four.png")
    reader = UsdShade.Shader(stage.GetPrimAtPath("/Paint/St"))
    turned = shader(
        stage,
        "/Paint/Turned",
        "UsdTransform2d",
        scale=(NAMES.Float2, Gf.Vec2f(2, 3)),
        rotation=(NAMES.Float, 90.0),
        translation=(NAMES.Float2, Gf.Vec2f(0.5, 0)),
        **{"in": (NAMES.Float2, reader, "result")},
    )
    st_input = UsdShade.Shader(stage.GetPrimAtPath("/Paint/Picture")).GetInput("st")
    st_input.ConnectToSource(turned.ConnectableAPI(), "result")
    painted(stage, paint)
    found = one_mesh(loaded(stage))
    assert uv_by_corner(found) == {(0, 0): [0.5, 0], (1, 0): [0.5, 2], (1, 1): [-2.5, 2], (0, 1): [-2.5, 0]}


def test_scale_and_wrapping_are_kept_large_textures_reduced_and_alpha_is_dropped(stage: Any, tmp_path: Path) -> None:
    picture(tmp_path / "four.png", FOUR)
    half = (NAMES.Float4, Gf.Vec4f(0.2140, 0.2140, 0.2140, 1))
    painted(stage, textured(stage, "/Paint", "./four.png", scale=half, wrapS=(NAMES.Token, "mirror")), "/Scaled")
    picture(tmp_path / "leaf.png", [[[0, 255, 0, 255], [0, 255, 0, 40]]])
    painted(stage, textured(stage, "/Leaf", "./leaf.png"), "/Opaque")
    picture(tmp_path / "large.png", np.zeros((8, 4096, 3)))
    painted(stage, textured(stage, "/Wide", "./large.png"), "/Large")
    scaled, opaque, large = loaded(stage).meshes
    assert np.abs(scaled.texture[1, 1].astype(int) - 127).max() <= 1
    assert scaled.wrap == "mirror"
    assert opaque.texture.shape == (1, 2, 3) and large.texture.shape == (4, 2048, 3)


def test_opacity_from_the_alpha_of_a_texture_makes_holes(stage: Any, tmp_path: Path) -> None:
    picture(tmp_path / "leaf.png", [[[0, 255, 0, 255], [0, 255, 0, 40]]])
    paint = textured(stage, "/Paint", "./leaf.png")
    surface = UsdShade.Shader(stage.GetPrimAtPath("/Paint/Surface"))
    reader = UsdShade.Shader(stage.GetPrimAtPath("/Paint/Picture"))
    surface.CreateInput("opacity", NAMES.Float).ConnectToSource(reader.ConnectableAPI(), "a")
    surface.CreateInput("opacityThreshold", NAMES.Float).Set(0.5)
    painted(stage, paint)
    assert one_mesh(loaded(stage)).texture.tolist() == [[[0, 255, 0, 255], [0, 255, 0, 0]]]


def test_geom_subsets_have_materials_of_their_own(stage: Any) -> None:
    points = [(x, y, 0) for y in range(2) for x in range(4)]
    made = mesh(stage, "/Strip", points, [(x, x + 1, x + 5, x + 4) for x in range(3)])
    made.CreateDisplayColorAttr([Gf.Vec3f(1, 1, 1)])
    for number, (name, paint) in enumerate({"Red": colour(1, 0, 0), "Green": colour(0, 1, 0)}.items()):
        part = UsdShade.MaterialBindingAPI.Apply(made.GetPrim()).CreateMaterialBindSubset(name, [number])
        bind(part, material(stage, f"/Looks/{name}", diffuseColor=paint))
    found = {part.path: part for part in loaded(stage).meshes}
    assert {path: np.round(part.colour).tolist() for path, part in found.items()} == {
        "/Strip/Red": [1, 0, 0],
        "/Strip/Green": [0, 1, 0],
        "/Strip": [1, 1, 1],
    }
    assert [len(part.triangles) for part in found.values()] == [2, 2, 2]
    assert found["/Strip/Green"].points[:, 0].tolist() != found["/Strip/Red"].points[:, 0].tolist()


def mdl(stage: Any, path: str = "/Paint", **inputs: Any) -> Any:
    made = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, f"{path}/Shader")
    surface.SetSourceAsset("OmniPBR.mdl", "mdl")
    surface.SetSourceAssetSubIdentifier("OmniPBR", "mdl")
    for name, (kind, value) in inputs.items():
        surface.CreateInput(name, kind).Set(value)
    made.CreateSurfaceOutput("mdl").ConnectToSource(surface.ConnectableAPI(), "out")
    return made


def test_omnipbr_gives_its_colour_or_its_texture_and_its_normal_map_is_named(stage: Any, tmp_path: Path) -> None:
    pixels = picture(tmp_path / "four.png", FOUR)
    tinted = {"diffuse_color_constant": colour(0.2140, 0, 1), "diffuse_tint": colour(1, 1, 0)}
    painted(stage, mdl(stage, normalmap_texture=(NAMES.Asset, "bumps.png"), **tinted), "/Plain")
    pictured = {"diffuse_texture": (NAMES.Asset, "./four.png"), "texture_scale": (NAMES.Float2, Gf.Vec2f(2, 2))}
    painted(stage, mdl(stage, "/Other", diffuse_color_constant=colour(1, 0, 0), **pictured), "/Pictured")
    scene = loaded(stage)
    plain, found = scene.meshes
    assert plain.colour == pytest.approx((0.5, 0, 0), abs=1e-3)
    assert scene.warnings == ("Normal maps are not drawn: /Paint/Shader",)
    assert np.array_equal(found.texture, pixels)
    assert (found.uvs.max(), found.colour) == (2, (1, 1, 1))


def test_omnipbr_emission_and_opacity_count_only_when_they_are_switched_on(stage: Any) -> None:
    values = {"emissive_color": colour(0, 0, 1), "opacity_constant": (NAMES.Float, 0.5)}
    for switch in (False, True):
        switches = dict.fromkeys(("enable_emission", "enable_opacity"), (NAMES.Bool, switch))
        painted(stage, mdl(stage, f"/Paint{switch}", **switches, **values), f"/Square{switch}")
    looks = [(look.emissive, look.opacity) for look in loaded(stage).meshes]
    assert looks == [((0, 0, 0), 1), (pytest.approx((0, 0, 1)), 0.5)]


def test_a_cube_without_coordinates_gets_the_average_of_its_texture_and_is_named(stage: Any, tmp_path: Path) -> None:
    picture(tmp_path / "four.png", FOUR)
    bind(UsdGeom.Cube.Define(stage, "/Cube"), textured(stage, "/Paint", "./four.png"))
    scene = loaded(stage)
    assert one_mesh(scene).colour == (0.5, 0.5, 0.5)
    assert scene.warnings == ("Texture on a surface without texture coordinates: /Cube",)


def test_a_missing_reference_and_a_missing_sublayer_are_named(stage: Any, capfd: pytest.CaptureFixture[str]) -> None:
    painted(stage)
    stage.GetRootLayer().subLayerPaths.append("./gone_layer.usda")
    stage.DefinePrim("/Rack").GetReferences().AddReference("omniverse://server/rack.usd")
    stage.DefinePrim("/Hatch").GetPayloads().AddPayload("./gone_hatch.usd")
    file = saved(stage)
    capfd.readouterr()
    scene = load_scene(file)
    text = "\n".join(scene.warnings)
    assert all(name in text for name in ("gone_layer.usda", "server/rack.usd", "gone_hatch.usd"))
    assert scene.triangles == 2
    assert capfd.readouterr().err == ""


def test_a_missing_texture_one_of_an_unknown_kind_and_tiles_beyond_the_first_are_named(
    stage: Any, tmp_path: Path
) -> None:
    (tmp_path / "light.exr").write_bytes(b"v/1\x01 and no picture")
    for tile in (1001, 1002):
        picture(tmp_path / f"skin.{tile}.png", [[[tile % 256, 0, 0]]])
    fallback = (NAMES.Float4, Gf.Vec4f(0, 1, 0, 1))
    painted(stage, textured(stage, "/Gone", "./gone.png", fallback=fallback), "/Missing")
    painted(stage, textured(stage, "/Light", "./light.exr"), "/Unknown")
    painted(stage, textured(stage, "/Skin", "./skin.<UDIM>.png"), "/Tiled")
    scene = loaded(stage)
    missing, unknown, tiled = scene.meshes
    warnings = sorted(scene.warnings)
    assert warnings[0] == "Only the first tile of UDIM textures is drawn: ./skin.<UDIM>.png"
    assert warnings[1] == "Texture not found: './gone.png' of /Gone/Picture"
    assert warnings[2].startswith("Texture of a kind that cannot be read") and len(warnings) == 3
    assert missing.colour == pytest.approx((0, 1, 0)) and unknown.texture is None
    assert tiled.texture.tolist() == [[[1001 % 256, 0, 0]]]


def test_shaders_nodes_and_materials_that_are_not_known_are_named_and_leave_the_display_colour(stage: Any) -> None:
    painted(stage, material(stage, "/Volume", "ND_volume"), "/Red").CreateDisplayColorAttr([Gf.Vec3f(1, 0, 0)])
    standard = "ND_standard_surface_surfaceshader"
    painted(stage, material(stage, "/Standard", standard, base_color=colour(0, 0, 1)), "/Blue")
    mixed = shader(stage, "/Mixed/Mix", "ND_mix_color3")
    painted(stage, material(stage, "/Mixed", diffuseColor=(NAMES.Color3f, mixed, "out")), "/Grey")
    unbound = painted(stage, path="/Unbound").GetPrim()
    UsdShade.MaterialBindingAPI.Apply(unbound)
    unbound.CreateRelationship("material:binding").SetTargets([Sdf.Path("/Looks/Gone")])
    scene = loaded(stage)
    assert [mesh.colour for mesh in scene.meshes[:2]] == [pytest.approx((1, 0, 0)), pytest.approx((0, 0, 1))]
    (base,) = (line for line in scene.warnings if line.startswith("Only the base colour of shaders"))
    assert {*scene.warnings} - {base} == {
        "Shaders of the kind 'ND_volume' cannot be drawn: /Volume/Surface",
        "Shader node that cannot be drawn: ND_mix_color3 at /Mixed/Mix",
        "Material not found: /Looks/Gone of /Unbound",
    }


def test_meshes_and_values_that_do_not_fit_are_left_out(stage: Any) -> None:
    mesh(stage, "/Broken", faces=[(0, 1, 9)])
    mesh(stage, "/Short", faceVertexCounts=[4, 4])
    mesh(stage, "/Endless", [(0, 0, 0), (1, 0, 0), (0, float("inf"), 0)], [(0, 1, 2)])
    mesh(stage, "/Empty", [], [])
    primvar(mesh(stage, "/Few"), "displayColor", NAMES.Color3fArray, "vertex", [Gf.Vec3f(1, 0, 0)] * 2)
    scene = loaded(stage)
    assert scene.warnings == (
        "Mesh with faces that do not fit its points: /Broken; /Short; /Endless",
        "Too few values for the faces: /Few.primvars:displayColor",
    )
    assert (one_mesh(scene).path, one_mesh(scene).colour) == ("/Few", (0.7, 0.7, 0.7))


def test_kinds_of_prims_lights_skins_draw_modes_subdivision_and_bumps_that_are_not_drawn_are_named(stage: Any) -> None:
    for number in range(8):
        UsdGeom.BasisCurves.Define(stage, f"/Hair{number}")
    UsdGeom.Points.Define(stage, "/Dust")
    bumps = shader(stage, "/Bumps", "UsdUVTexture", file=(NAMES.Asset, "bumps.png"))
    bumpy = {"normal": (NAMES.Normal3f, bumps, "rgb"), "displacement": (NAMES.Float, bumps, "r")}
    made = painted(stage, material(stage, "/Plaster", **bumpy))
    made.GetSubdivisionSchemeAttr().Set("catmullClark")
    UsdSkel.BindingAPI.Apply(made.GetPrim())
    UsdLux.DomeLight.Define(stage, "/Sky")
    stage.DefinePrim("/Fog", "MagicFog")
    house = UsdGeom.Xform.Define(stage, "/House").GetPrim()
    UsdGeom.ModelAPI.Apply(house).CreateModelDrawModeAttr("cards")
    scene = loaded(stage)
    assert scene.triangles == 2
    assert {*scene.warnings} == {
        "BasisCurves prims are not drawn: /Hair0; /Hair1; /Hair2; /Hair3; /Hair4 and 3 more",
        "Points prims are not drawn: /Dust",
        "Skinned meshes are drawn in their rest shape: /Square",
        "Lights are not used, the scene is lit evenly: /Sky",
        "Prims of the unknown type 'MagicFog' are not drawn: /Fog",
        "The geometry is drawn instead of the draw mode 'cards': /House",
        "Subdivision surfaces are drawn without their subdivision: /Square",
        "Normal maps are not drawn: /Plaster/Surface",
        "Displacement is not drawn: /Plaster/Surface",
    }


def test_copies_beyond_the_limit_are_counted(stage: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(walking, "LARGEST_INSTANCER", 6)
    places = [(number, 0, 0) for number in range(6)]
    instancer(stage, "/Grass", ["/Grass/Blade", "/Grass/Gone"], [0] * 5 + [1], places)
    mesh(stage, "/Grass/Blade")
    scene = loaded(stage)
    assert scene.triangles == 6
    assert scene.warnings == (
        "Only the first 3 of 5 copies are drawn: /Grass/Blade",
        "Prototype not found: /Grass/Gone of /Grass",
    )
