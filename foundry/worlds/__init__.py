"""Worlds: deterministic simulations that state questions, take answers and return records."""
