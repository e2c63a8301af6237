"""Models served through OpenAI's API."""
