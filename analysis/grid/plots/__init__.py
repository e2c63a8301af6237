"""Draws what is shown of runs of 2D worlds; computes nothing."""
