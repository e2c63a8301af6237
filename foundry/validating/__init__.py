"""Runs scripted policies with known analytic results, and compares."""
