"""Builds the tables of an analysis, and writes them in several formats."""
