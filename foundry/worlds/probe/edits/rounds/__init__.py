"""Edits of what games show."""
