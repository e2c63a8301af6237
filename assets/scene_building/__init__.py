"""Parts of the shipped scenes: shapes, drawn textures, furniture, and one file per scene."""
