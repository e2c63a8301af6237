"""Computes what plots show; draws nothing."""
