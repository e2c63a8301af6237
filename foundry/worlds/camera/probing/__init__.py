"""A 3D world that asks, after a walk, what was seen on it and where it is."""
