"""The tables that foundry 0.1 made of the sweeps in `tests/data`.

`python tests/runs/kept_tables.py <sweep> ...` keeps them.

They were kept once, from sweeps analysed with the code as it was then, and say what may never change.
"""

from __future__ import annotations

import io
import sys
import zipfile
from pathlib import Path

import pandas as pd

FILE = Path(__file__).parents[1] / "data" / "tables_0_1.zip"
TABLES = ("signatures", "comparison", "contrasts", "variance", "fingerprint")


def kept_table(sweep: str, name: str) -> pd.DataFrame:
    """Return a table of a sweep (`grid`, `camera`) as it was."""
    with zipfile.ZipFile(FILE) as archive:
        return pd.read_csv(io.BytesIO(archive.read(f"{sweep}/{name}.csv")), keep_default_na=True)


def keep(sweeps: list[Path]) -> None:
    """Write the tables of analysed sweeps into the file."""
    with zipfile.ZipFile(FILE, "w", zipfile.ZIP_LZMA) as archive:
        for sweep in sweeps:
            for name in TABLES:
                content = (sweep / "analysis" / f"{name}.csv").read_bytes()
                archive.writestr(zipfile.ZipInfo(f"{sweep.name}/{name}.csv"), content, zipfile.ZIP_LZMA)


if __name__ == "__main__":
    keep([Path(one) for one in sys.argv[1:]])
