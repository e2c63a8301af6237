"""Compares groups of runs with pure functions from tables to tables, for commands and notebooks.

Each group has one independent value per seed, and groups are paired by seed. `docs/statistics.md` explains the methods
and every column.
"""
