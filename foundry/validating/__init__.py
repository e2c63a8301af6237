"""Runs scripted policies, and compares their results with the values that formulas give."""
