"""Findings: differences, the largest first, with numbers, claims and example moments, written to `findings.json`."""
