"""Draws plots of runs of 2D worlds; computes nothing."""
