"""Probes in the viewer: the moments, and what each model did in them."""
