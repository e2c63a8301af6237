"""Declarations before the runs, and the number of undeclared looks at the data."""
