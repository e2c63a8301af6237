"""The settings of a 3D world and their checks."""

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any

import msgspec

from foundry.errors import InputError, not_found
from foundry.worlds.camera.language import Limits
from foundry.worlds.validation import read_settings, refuse_repeated_names

Positive = Annotated[float, msgspec.Meta(gt=0)]
Size = Annotated[int, msgspec.Meta(ge=16, le=4096)]
Point2 = tuple[float, float]
Point3 = tuple[float, float, float]

BOUNDARIES = ("stop", "slide")
IMAGE_FORMATS = ("png", "jpeg")


class SceneSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The scene's file, the prims to leave out, and the folder from which it may read; None means the file's folder."""

    asset: str
    exclude: list[str] = []
    root: str | None = None


class BodySettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The size of the agent's body, metres."""

    radius: Positive
    height: Positive
    eye_height: Positive
    step_height: Annotated[float, msgspec.Meta(ge=0)]


class EyeSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The agent's eye: size of its images in pixels, vertical field of view and largest pitch in degrees."""

    width: Size
    height: Size
    fov: Annotated[float, msgspec.Meta(gt=1, lt=170)]
    pitch_limit: Annotated[float, msgspec.Meta(gt=0, lt=90)]


class StartSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The first pose, or the region from which it is drawn; metres and degrees."""

    region: tuple[Point2, Point2] | None = None
    x: float | None = None
    y: float | None = None
    z: float | None = None
    yaw: float | None = None
    pitch: float = 0.0


class TargetSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A target: its name, patterns of its prims' paths, and the distance that counts as reached, metres."""

    name: str
    prims: list[str]
    radius: Positive


class CameraSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """All settings of a 3D world; see `conf/world/usd.yaml`."""

    name: str
    task: str
    steps: Annotated[int, msgspec.Meta(ge=1)]
    floor: float | None
    bounds: tuple[Point3, Point3] | None
    boundary: str
    history: Annotated[int, msgspec.Meta(ge=0)]
    image_format: str
    keep_images: bool
    scene: SceneSettings
    start: StartSettings
    targets: list[TargetSettings]
    body: BodySettings
    camera: EyeSettings


def read_camera_settings(values: Mapping[str, Any]) -> CameraSettings:
    """Return the settings of a 3D world.

    Raises:
        InputError: a key is unknown or missing, or a value is of the wrong type or out of range.
    """
    settings = read_settings(CameraSettings, values, "world")
    _check(settings)
    return settings


def read_limits(values: Mapping[str, Any]) -> Limits:
    """Return the limits of a command.

    Raises:
        InputError: a limit is unknown or out of range.
    """
    known = [field.name for field in dataclasses.fields(Limits)]
    for name in values:
        if name not in known:
            raise not_found("Setting of world.limits", str(name), known)
    return Limits(**values)


def _check(settings: CameraSettings) -> None:
    for key, value, known in (
        ("boundary", settings.boundary, BOUNDARIES),
        ("image_format", settings.image_format, IMAGE_FORMATS),
    ):
        if value not in known:
            raise InputError(f"world.{key}={value} is not one of: {', '.join(known)}.")
    start = settings.start
    if (start.x is None) != (start.y is None):
        given, missing = ("x", "y") if start.y is None else ("y", "x")
        raise InputError(
            f"world.start.{given} is {getattr(start, given):g}, but world.start.{missing} is null. Set both to "
            "metres, or both to null to draw the start from world.start.region."
        )
    if start.x is not None and start.region is not None:
        raise InputError("world.start gives a place and a region: set one of them to null.")
    refuse_repeated_names((target.name for target in settings.targets), "world.targets")
