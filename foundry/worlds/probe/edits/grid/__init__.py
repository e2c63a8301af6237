"""Edits of the 2D world's observations."""
