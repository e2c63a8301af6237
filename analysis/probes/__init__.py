"""Probes: who decides what in the same recorded moments, who differs from whom, and what an edit changes."""

from analysis.probes.probe_tables import ProbeAnalysis, analyze_probe

__all__ = ["ProbeAnalysis", "analyze_probe"]
