"""The paths of files that foundry ships, and of files that foundry keeps in a user's home."""

import os
from pathlib import Path

import platformdirs

PACKAGE = Path(__file__).resolve().parent


def shipped(name: str) -> Path:
    """Return a folder that foundry ships: in the installed wheel, else in the clone."""
    packaged = PACKAGE / name
    return packaged if packaged.is_dir() else PACKAGE.parent / name


def conf_dir() -> Path:
    """Return the folder of the configuration groups."""
    return shipped("conf")


def sweeps_dir() -> Path:
    """Return the folder with the files of named sweeps; for example, `+sweep=first` uses `first.yaml`."""
    return shipped("sweeps")


def scene_cache_dir() -> Path:
    """Return the folder for data computed from scenes: FOUNDRY_SCENE_CACHE, else in the user's cache."""
    folder = os.environ.get("FOUNDRY_SCENE_CACHE")
    return Path(folder) if folder else Path(platformdirs.user_cache_dir("foundry")) / "scenes"


def weights_cache_file() -> Path:
    """Return the path of the file for the hashes of local weights.

    The variable FOUNDRY_WEIGHTS_CACHE names it; without this variable, it is in the cache folder of the user.
    """
    file = os.environ.get("FOUNDRY_WEIGHTS_CACHE")
    return Path(file) if file else Path(platformdirs.user_cache_dir("foundry")) / "weights.json"


def user_config_file() -> Path:
    """Return the file of the user's own defaults; it may not exist."""
    return Path(platformdirs.user_config_dir("foundry", appauthor=False)) / "config.yaml"


def shipped_parts() -> Path:
    """Return the folder with the templates of `foundry new`."""
    return PACKAGE / "new_parts"


def assets_dir() -> Path:
    """Return the folder with the shipped scenes."""
    return shipped("assets")
