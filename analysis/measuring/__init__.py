"""Computes the measures and events of runs, and caches the results."""
