"""Worlds of rounds without space, such as games, markets and conversations; agents decide at once or in turn."""
