"""The signatures of runs of 2D worlds, one module each."""
