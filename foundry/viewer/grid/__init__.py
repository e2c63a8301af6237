"""Runs of the grid form in the viewer."""
