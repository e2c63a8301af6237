"""Makes the scenes of this folder: `python assets/make_scenes.py [--out FOLDER] [SCENE ...]`."""

import argparse
from pathlib import Path

from scene_building import gallery, kibo, office

SCENES = {"kibo": kibo.build, "office": office.build, "gallery": gallery.build}


def main() -> None:
    """Write the scenes asked for, or all."""
    parser = argparse.ArgumentParser(description="Make the scenes that ship with foundry.")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"of {', '.join(SCENES)}; all when none is named")
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parent, help="folder to write into")
    asked = parser.parse_args()
    unknown = sorted(set(asked.scenes) - set(SCENES))
    if unknown:
        parser.error(f"scene '{unknown[0]}' not found. Available: {', '.join(SCENES)}.")
    for name in asked.scenes or SCENES:
        SCENES[name]().save(asked.out)


if __name__ == "__main__":
    main()
