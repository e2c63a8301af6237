"""The shipped 2D worlds, loaded without Hydra."""

from typing import Any

from hydra.utils import instantiate
from omegaconf import OmegaConf

from foundry.paths import conf_dir
from foundry.worlds.grid.grid_world import GridScenario


def load_world(name: str) -> dict[str, Any]:
    """Return the settings of a shipped world, its layout put in by hand."""
    settings = OmegaConf.load(conf_dir() / "world" / f"{name}.yaml")
    settings.pop("defaults")
    settings.layout = OmegaConf.load(conf_dir() / "layout" / "uniform.yaml")
    return dict(OmegaConf.to_container(settings))


def make(name: str = "cafe_library", **changes: Any) -> GridScenario:
    scenario: GridScenario = instantiate({**load_world(name), **changes}, _convert_="all")
    return scenario


def make_at(*cells: tuple[int, int], **changes: Any) -> GridScenario:
    layout = {"_target_": "foundry.worlds.grid.layouts.Explicit", "positions": [list(cell) for cell in cells]}
    return make(agents=len(cells), layout=layout, **changes)
