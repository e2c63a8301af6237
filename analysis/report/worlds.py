"""Compares the worlds of several sweeps."""

from collections.abc import Sequence

from foundry.storing.store import SweepFolder, leaves


def world_differences(sweeps: Sequence[SweepFolder]) -> list[tuple[str, ...]]:
    """Return the path and the values in each sweep, for each setting that differs between the sweeps' worlds."""
    found = [_values(sweep) for sweep in sweeps]
    paths = dict.fromkeys(path for values in found for path in values)
    differing = [path for path in paths if len({tuple(values.get(path, ())) for values in found}) > 1]
    return [(path, *(" or ".join(values.get(path, ["none"])) for values in found)) for path in differing]


def _values(sweep: SweepFolder) -> dict[str, list[str]]:
    """Return the values of each setting of the worlds of a sweep."""
    found: dict[str, set[str]] = {}
    for condition in sweep.sweep.conditions:
        for path, value in leaves(condition.config["world"]):
            found.setdefault(path, set()).add(value)
    return {path: sorted(values) for path, values in found.items()}
