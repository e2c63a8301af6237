"""Verifies, compares, continues and bundles recorded sweeps."""
