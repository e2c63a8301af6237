"""Plays scripted policies whose results are known in closed form, and holds what comes out against them."""
