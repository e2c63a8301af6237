"""Runs of the camera form in the viewer."""
