"""Policies for worlds of rounds."""
