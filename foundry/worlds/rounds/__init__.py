"""Worlds of rounds: agents that decide at once or in turn, step by step, with no space: games, markets, talk."""
