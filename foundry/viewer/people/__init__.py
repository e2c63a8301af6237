"""The page where people answer questions, and its server."""
