"""Computes the content of plots; draws nothing."""
