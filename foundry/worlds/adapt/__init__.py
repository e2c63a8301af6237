"""Environments of others as worlds: Gymnasium's for one agent, PettingZoo's for several (extra `gym`)."""
