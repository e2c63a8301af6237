"""Findings: differences by size, each with numbers, standing and example moments, written to `findings.json`."""
