"""Models that an OpenAI-compatible server serves."""
