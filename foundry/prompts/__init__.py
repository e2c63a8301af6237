"""Templates that turn an observation into the messages a model is sent."""
