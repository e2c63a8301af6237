"""The tables of an analysis, and their output formats."""
