"""Models that are people, and the desk at which they are asked."""
