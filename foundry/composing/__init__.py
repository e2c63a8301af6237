"""Turns a command line into a checked sweep, and makes its plan."""
