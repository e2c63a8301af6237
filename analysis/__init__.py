"""Reads sweeps and describes how the models in them behaved: signatures, comparison, plots."""

from analysis.load import Loaded, load
from analysis.pipeline import Analysis, analyze

__all__ = ["Analysis", "Loaded", "analyze", "load"]
