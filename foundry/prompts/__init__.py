"""Templates that convert an observation to the messages for a model."""
