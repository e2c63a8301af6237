"""Findings: differences by size, each with its numbers, its standing and example moments; `findings.json`."""
