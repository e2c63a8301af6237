"""Loads USD files as triangles."""
