"""Environments of other libraries as worlds: Gymnasium for one agent, PettingZoo for several agents."""
