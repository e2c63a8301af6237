"""Models whose weights this process holds."""
