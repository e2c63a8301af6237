"""Edits of keys that worlds of several forms have."""
