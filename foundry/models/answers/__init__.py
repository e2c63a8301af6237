"""The answers that were given before."""
