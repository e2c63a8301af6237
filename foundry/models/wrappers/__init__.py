"""Wrappers of a model: cache, warm-up, limit, retry, confirmation."""
