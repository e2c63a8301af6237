"""The parts of which the shipped scenes are made: shapes, drawn textures, furniture, and one file per scene."""
