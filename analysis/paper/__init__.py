"""Texts of an analysis: a summary, the methods, references, and a card for each model."""
