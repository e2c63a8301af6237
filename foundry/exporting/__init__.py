"""Writes a sweep in the formats of other tools: prompts, replies and scores."""
