"""Handles declarations before the runs, and counts tests that were not declared."""
