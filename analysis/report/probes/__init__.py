"""Writes one page about a probe, which asked several models about the same moments."""
