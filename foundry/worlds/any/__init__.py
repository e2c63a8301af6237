"""Policies and edits of worlds of every form."""
