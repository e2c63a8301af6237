"""Materials give surfaces their colour and their pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdShade, UsdUtils

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
FOUR = [[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]]
"""Red and green above blue and white."""


def one(scene: Any) -> Any:
    assert len(scene.meshes) == 1
    return scene.meshes[0]


def painted(stage: Any, paint: Any) -> Any:
    """Add a square with texture coordinates and this material."""
    made = mesh(stage, "/Square")
    texture_coordinates(made, CORNERS)
    bind(made, paint)
    return made


def uv_by_corner(found: Any) -> dict[tuple[float, ...], list[float]]:
    pairs = zip(found.points[:, :2].tolist(), found.uvs.tolist(), strict=True)
    return {tuple(point): np.round(uv, 6).tolist() for point, uv in pairs}


def test_a_preview_surface_gives_colour_opacity_and_emission(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        inputs = {"diffuseColor": Gf.Vec3f(0.2140, 0, 0), "emissiveColor": Gf.Vec3f(0, 1, 0)}
        colours = {name: (NAMES.Color3f, value) for name, value in inputs.items()}
        painted(stage, material(stage, "/Paint", opacity=(NAMES.Float, 0.5), **colours))

    found = one(load(tmp_path, build))
    assert found.colour == pytest.approx((0.5, 0, 0), abs=1e-3)
    assert (found.opacity, found.emissive) == (0.5, pytest.approx((0, 1, 0)))


def test_a_material_counts_more_than_the_display_colour(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        made = painted(stage, material(stage, "/Paint", diffuseColor=(NAMES.Color3f, Gf.Vec3f(0, 0, 1))))
        made.CreateDisplayColorAttr([Gf.Vec3f(1, 0, 0)])

    assert one(load(tmp_path, build)).colour == pytest.approx((0, 0, 1))


def test_a_colour_may_come_from_the_interface_of_the_material(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        paint = material(stage, "/Paint", diffuseColor=(NAMES.Color3f, Gf.Vec3f(0)))
        public = paint.CreateInput("tint", NAMES.Color3f)
        public.Set(Gf.Vec3f(0, 1, 0))
        UsdShade.Shader(stage.GetPrimAtPath("/Paint/Surface")).GetInput("diffuseColor").ConnectToSource(public)
        painted(stage, paint)

    assert one(load(tmp_path, build)).colour == pytest.approx((0, 1, 0))


def test_a_colour_may_come_from_a_primvar(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        reader = shader(stage, "/Paint/Reader", "UsdPrimvarReader_float3", varname=(NAMES.String, "paint"))
        made = painted(stage, material(stage, "/Paint", diffuseColor=(NAMES.Color3f, reader, "result")))
        primvar(made, "paint", NAMES.Color3fArray, "constant", [Gf.Vec3f(1, 0, 1)])

    assert one(load(tmp_path, build)).colour == pytest.approx((1, 0, 1))


def test_a_texture_is_read_with_its_coordinates_also_out_of_a_package(tmp_path: Path) -> None:
    pixels = picture(tmp_path / "four.png", FOUR)
    found = one(load(tmp_path, lambda stage: painted(stage, textured(stage, "/Paint", "./four.png"))))
    assert np.array_equal(found.texture, pixels)
    assert uv_by_corner(found) == {(0, 0): [0, 0], (1, 0): [1, 0], (1, 1): [1, 1], (0, 1): [0, 1]}
    assert (found.colour, found.wrap) == ((1, 1, 1), "repeat")
    root = write_stage(tmp_path / "root.usda", lambda stage: painted(stage, textured(stage, "/Paint", "./four.png")))
    assert UsdUtils.CreateNewUsdzPackage(str(root), str(tmp_path / "all.usdz"))
    assert np.array_equal(one(load_scene(tmp_path / "all.usdz")).texture, pixels)


def test_two_meshes_share_one_texture(tmp_path: Path) -> None:
    picture(tmp_path / "four.png", FOUR)

    def build(stage: Any) -> None:
        for number in range(2):
            made = mesh(stage, f"/Square{number}")
            texture_coordinates(made, CORNERS)
            bind(made, textured(stage, f"/Paint{number}", "./four.png"))

    first, second = load(tmp_path, build).meshes
    assert first.texture is second.texture


def test_texture_coordinates_are_scaled_turned_and_moved(tmp_path: Path) -> None:
    picture(tmp_path / "four.png", FOUR)

    def build(stage: Any) -> None:
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

    found = one(load(tmp_path, build))
    assert uv_by_corner(found) == {(0, 0): [0.5, 0], (1, 0): [0.5, 2], (1, 1): [-2.5, 2], (0, 1): [-2.5, 0]}


def test_scale_and_wrapping_of_a_texture_are_kept(tmp_path: Path) -> None:
    picture(tmp_path / "four.png", FOUR)

    def build(stage: Any) -> None:
        half = (NAMES.Float4, Gf.Vec4f(0.2140, 0.2140, 0.2140, 1))
        paint = textured(stage, "/Paint", "./four.png", scale=half, wrapS=(NAMES.Token, "mirror"))
        painted(stage, paint)

    found = one(load(tmp_path, build))
    assert np.abs(found.texture[1, 1].astype(int) - 127).max() <= 1
    assert found.wrap == "mirror"


def test_opacity_from_the_alpha_of_a_texture_makes_holes(tmp_path: Path) -> None:
    pixels = picture(tmp_path / "leaf.png", [[[0, 255, 0, 255], [0, 255, 0, 40]]])

    def build(stage: Any) -> None:
        paint = textured(stage, "/Paint", "./leaf.png")
        surface = UsdShade.Shader(stage.GetPrimAtPath("/Paint/Surface"))
        reader = UsdShade.Shader(stage.GetPrimAtPath("/Paint/Picture"))
        surface.CreateInput("opacity", NAMES.Float).ConnectToSource(reader.ConnectableAPI(), "a")
        surface.CreateInput("opacityThreshold", NAMES.Float).Set(0.5)
        painted(stage, paint)

    found = one(load(tmp_path, build))
    assert found.texture[0].tolist() == [[0, 255, 0, 255], [0, 255, 0, 0]]
    assert pixels.shape == found.texture.shape


def test_a_large_texture_is_reduced_and_alpha_that_is_not_asked_for_is_dropped(tmp_path: Path) -> None:
    picture(tmp_path / "leaf.png", [[[0, 255, 0, 255], [0, 255, 0, 40]]])
    found = one(load(tmp_path, lambda stage: painted(stage, textured(stage, "/Paint", "./leaf.png"))))
    assert found.texture.shape == (1, 2, 3)
    picture(tmp_path / "large.png", np.zeros((8, 4096, 3)))
    found = one(load(tmp_path, lambda stage: painted(stage, textured(stage, "/Paint", "./large.png"))))
    assert found.texture.shape == (4, 2048, 3)


def test_geom_subsets_have_materials_of_their_own(tmp_path: Path) -> None:
    points = [(x, y, 0) for y in range(2) for x in range(4)]
    faces = [(x, x + 1, x + 5, x + 4) for x in range(3)]

    def build(stage: Any) -> None:
        made = mesh(stage, "/Strip", points, faces)
        made.CreateDisplayColorAttr([Gf.Vec3f(1, 1, 1)])
        for number, name in enumerate(("Red", "Green")):
            colour = Gf.Vec3f(0)
            colour[number] = 1
            part = UsdShade.MaterialBindingAPI.Apply(made.GetPrim()).CreateMaterialBindSubset(name, [number])
            bind(part, material(stage, f"/Looks/{name}", diffuseColor=(NAMES.Color3f, colour)))

    found = {part.path: part for part in load(tmp_path, build).meshes}
    assert {path: np.round(part.colour).tolist() for path, part in found.items()} == {
        "/Strip/Red": [1, 0, 0],
        "/Strip/Green": [0, 1, 0],
        "/Strip": [1, 1, 1],
    }
    assert [len(part.triangles) for part in found.values()] == [2, 2, 2]
    assert found["/Strip/Green"].points[:, 0].tolist() != found["/Strip/Red"].points[:, 0].tolist()


def mdl(stage: Any, **inputs: Any) -> Any:
    """Add an OmniPBR material."""
    made = UsdShade.Material.Define(stage, "/Paint")
    surface = UsdShade.Shader.Define(stage, "/Paint/Shader")
    surface.SetSourceAsset("OmniPBR.mdl", "mdl")
    surface.SetSourceAssetSubIdentifier("OmniPBR", "mdl")
    for name, (kind, value) in inputs.items():
        surface.CreateInput(name, kind).Set(value)
    made.CreateSurfaceOutput("mdl").ConnectToSource(surface.ConnectableAPI(), "out")
    return made


def test_a_normal_map_of_omnipbr_is_named(tmp_path: Path) -> None:
    scene = load(tmp_path, lambda stage: painted(stage, mdl(stage, normalmap_texture=(NAMES.Asset, "bumps.png"))))
    assert scene.warnings == ("Normal maps are not drawn: /Paint/Shader",)


def test_omnipbr_gives_its_colour(tmp_path: Path) -> None:
    inputs = {"diffuse_color_constant": Gf.Vec3f(0.2140, 0, 1), "diffuse_tint": Gf.Vec3f(1, 1, 0)}
    colours = {name: (NAMES.Color3f, value) for name, value in inputs.items()}
    found = one(load(tmp_path, lambda stage: painted(stage, mdl(stage, **colours))))
    assert found.colour == pytest.approx((0.5, 0, 0), abs=1e-3)


def test_omnipbr_gives_its_texture(tmp_path: Path) -> None:
    pixels = picture(tmp_path / "four.png", FOUR)
    inputs = {
        "diffuse_texture": (NAMES.Asset, "./four.png"),
        "diffuse_color_constant": (NAMES.Color3f, Gf.Vec3f(1, 0, 0)),
        "texture_scale": (NAMES.Float2, Gf.Vec2f(2, 2)),
    }
    found = one(load(tmp_path, lambda stage: painted(stage, mdl(stage, **inputs))))
    assert np.array_equal(found.texture, pixels)
    assert found.uvs.max() == 2
    assert found.colour == (1, 1, 1)


def test_omnipbr_emission_and_opacity_count_only_when_they_are_switched_on(tmp_path: Path) -> None:
    def inputs(switch: bool) -> dict[str, Any]:
        return {
            "enable_emission": (NAMES.Bool, switch),
            "emissive_color": (NAMES.Color3f, Gf.Vec3f(0, 0, 1)),
            "enable_opacity": (NAMES.Bool, switch),
            "opacity_constant": (NAMES.Float, 0.5),
        }

    looks = [
        one(load(tmp_path / f"{switch}.usda", lambda stage, s=switch: painted(stage, mdl(stage, **inputs(s)))))
        for switch in (False, True)
    ]
    assert [(look.emissive, look.opacity) for look in looks] == [((0, 0, 0), 1), (pytest.approx((0, 0, 1)), 0.5)]


def test_a_cube_without_coordinates_gets_the_average_of_its_texture_and_is_named(tmp_path: Path) -> None:
    picture(tmp_path / "four.png", FOUR)

    def build(stage: Any) -> None:
        bind(UsdGeom.Cube.Define(stage, "/Cube"), textured(stage, "/Paint", "./four.png"))

    scene = load(tmp_path, build)
    assert one(scene).colour == (0.5, 0.5, 0.5)
    assert scene.warnings == ("Texture on a surface without texture coordinates: /Cube",)
