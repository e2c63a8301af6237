"""What stands around a model: cache, warm-up, limit, retry, confirmation."""
