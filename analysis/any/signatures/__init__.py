"""The signatures of runs of every form, one module each."""
