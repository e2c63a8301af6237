"""What a 2D world can have beside places and fires: walls, exits, crowds, sight, spreading fires, energy, food."""
