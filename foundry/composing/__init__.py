"""From a command line to a checked sweep and its plan."""
