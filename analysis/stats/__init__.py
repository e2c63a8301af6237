"""Compares groups of runs: pure functions from tables to tables, for the command and for notebooks.

The independent value is one number per group and seed; groups are paired by seed. `docs/statistics.md` explains the
methods and every column.
"""
