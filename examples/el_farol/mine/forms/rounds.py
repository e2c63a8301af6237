"""The page of the bar: how many went, on top of what shows any run."""

from pathlib import Path

PAGE = Path(__file__).with_name("rounds.js")
