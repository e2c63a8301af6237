"""The page on which people answer, and its server."""
