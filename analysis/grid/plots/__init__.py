"""Draws plots of runs of 2D worlds from computed content."""
