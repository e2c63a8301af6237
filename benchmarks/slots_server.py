"""The test server with so many slots and service times as spread as those of a model: `--slots 4 --mean 0.05`."""

from __future__ import annotations

import argparse
import math
import sys
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests"))

from ollama_cases import ChatCase, grid_answer
from ollama_server import OllamaServer

SPREAD = 0.5
"""Standard deviation of the logarithm: one call in twenty takes more than twice as long as the median."""


def main() -> None:
    """Serve until interrupted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--slots", type=int, required=True)
    parser.add_argument("--mean", type=float, required=True, help="seconds of work per call, on average")
    parser.add_argument("--begun", type=Path, required=True, help="file that gets the time of the first call")
    asked = parser.parse_args()

    def answer(body: Mapping[str, Any]) -> ChatCase:
        """Answer after a time that the call's seed decides."""
        normal = np.random.default_rng(body["options"]["seed"]).standard_normal()
        return ChatCase(text=grid_answer(body), delay_s=asked.mean * math.exp(SPREAD * normal - SPREAD**2 / 2))

    def note(number: int, body: Mapping[str, Any]) -> None:
        if number == 1:
            asked.begun.write_text(f"{time.time()}", encoding="utf-8")

    with OllamaServer(answer, slots=asked.slots, on_chat=note, keep_bodies=False) as server:
        sys.stdout.write(f"{server.url}\n")
        sys.stdout.flush()
        threading.Event().wait()


if __name__ == "__main__":
    main()
