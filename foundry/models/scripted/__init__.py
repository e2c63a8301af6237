"""Policies that answer in text like a model, from the structured observation: one file per policy."""
