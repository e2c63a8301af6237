"""Tables of runs without any run."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.tables.signature_table import KEYS, SignatureTable

MEASURE = "idle_rate.chosen"


def table(rows: list[dict[str, object]], factors: tuple[str, ...] = ()) -> SignatureTable:
    """Return a table of runs given by model, seed, measures, and what else differs from the usual."""
    filled = [{"run": n, "world": "w", "prompt": "p", "status": "complete", **row} for n, row in enumerate(rows)]
    measures = tuple(dict.fromkeys(key for row in rows for key in row if "." in key and key not in factors))
    more = [key for key in ("baseline",) if key in rows[0]]
    frame = pd.DataFrame(filled)[[*KEYS, *more, *factors, *measures]]
    present = tuple(frozenset(key for key in row if key in measures) for row in rows)
    return SignatureTable(frame, factors, measures, present)


def runs(model: str, values: Sequence[float], measure: str = MEASURE, **more: object) -> list[dict[str, object]]:
    return [{"model": model, "seed": seed, measure: float(value), **more} for seed, value in enumerate(values)]


def table_of(values: np.ndarray, measures: Sequence[str]) -> SignatureTable:
    """Return the table of values (models, seeds, measures); models are called a, b, c."""
    models, seeds, _ = values.shape
    names = np.repeat([chr(ord("a") + index) for index in range(models)], seeds)
    keys = pd.DataFrame({
        "run": range(models * seeds), "world": "w", "model": names, "prompt": "p",
        "seed": np.tile(np.arange(seeds), models), "status": "complete",
    })  # fmt: skip
    frame = pd.concat([keys, pd.DataFrame(values.reshape(-1, len(measures)), columns=list(measures))], axis=1)
    return SignatureTable(frame, (), tuple(measures), (frozenset(measures),) * len(frame))
