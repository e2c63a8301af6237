"""The comparison of groups of runs: pure functions from tables to tables, for the command and for notebooks.

The independent value is that of a seed: one number per group and seed, groups paired by seed. `docs/statistics.md`
says what is done, why, and how to read every column.
"""
