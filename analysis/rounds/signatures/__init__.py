"""The signatures of runs of worlds of rounds, one module each."""
