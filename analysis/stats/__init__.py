"""The comparison of groups of runs: pure functions from tables to tables, for the command and for notebooks.

A seed gives the independent value: one number per group and seed, with groups paired by seed. `docs/statistics.md`
says what is done, why, and how to read every column.
"""
