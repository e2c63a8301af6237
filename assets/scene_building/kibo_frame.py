"""The position of the laboratory module, in metres and in the coordinates of the task."""

X_AIRLOCK, X_HATCH = -5.2, 5.8
AXIS_Y, FLOOR = 20.1, -0.2358
HALF, HEIGHT = 1.1, 2.2
CEILING = FLOOR + HEIGHT
PORT_Y, STARBOARD_Y = AXIS_Y - HALF, AXIS_Y + HALF
