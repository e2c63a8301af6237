"""From a command line to a checked sweep, and what it would ask."""
