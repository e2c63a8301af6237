"""Quantities of a form that move more than a number."""
