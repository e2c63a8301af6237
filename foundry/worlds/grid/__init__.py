"""The 2D worlds: a bounded grid with places and fires, where agents talk to those near them and move."""
