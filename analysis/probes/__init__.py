"""Probes: decisions of models in the same recorded moments, differences between models, and effects of edits."""

from analysis.probes.probe_tables import ProbeAnalysis, analyze_probe

__all__ = ["ProbeAnalysis", "analyze_probe"]
