"""Recorded moments as a world: the same questions before every model, as they were or edited."""
