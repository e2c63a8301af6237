"""Models: backends that answer requests, and wrappers with the same interface."""
