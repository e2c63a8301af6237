"""Optional parts of a 2D world: walls, exits, crowds, sight, spreading fires, energy and food."""
