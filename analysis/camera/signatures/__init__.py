"""The signatures of runs of 3D worlds, one module each."""
