"""Policies and edits that work in every world, whatever its form."""
