"""A 3D world in which a way is told, and is to be followed."""
