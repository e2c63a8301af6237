"""Probes in the viewer: the moments, and each model's choices in them."""
