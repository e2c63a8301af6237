"""Runs: on this machine, on a cluster, at a URL."""
