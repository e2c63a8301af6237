"""Plays runs on this machine or on a cluster, and exchanges them through a URL."""
