"""Measures runs, and remembers what was measured."""
