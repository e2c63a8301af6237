"""Writes an analysis in words: summary, methods, references, and a card for each model."""
