"""The signatures for runs in rounds, one module each."""
