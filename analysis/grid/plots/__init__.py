"""Draws plots of runs of 2D worlds; other modules compute what the plots show."""
