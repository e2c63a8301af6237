"""Where the agent can stand, walk and get to."""
