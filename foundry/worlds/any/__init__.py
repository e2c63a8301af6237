"""Policies and edits for worlds of every form."""
