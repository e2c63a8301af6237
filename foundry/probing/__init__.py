"""Composes probes from recorded sweeps: every model gets the same moments."""
