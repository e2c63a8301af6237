"""Runs of any form in a window."""

from foundry.replay.any.window import PictureWindow

WINDOW = PictureWindow
