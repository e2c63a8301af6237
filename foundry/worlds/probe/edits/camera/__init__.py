"""Edits of what is seen and told in 3D worlds."""
