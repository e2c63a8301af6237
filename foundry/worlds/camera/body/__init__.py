"""Places where the agent can stand, and paths between them."""
