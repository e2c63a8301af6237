"""Recorded moments as a world: every model gets the same questions, as recorded or edited."""
