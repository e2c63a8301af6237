"""People as models, and the desk that asks them."""
