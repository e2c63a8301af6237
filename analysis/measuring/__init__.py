"""Measures runs, and caches the results."""
