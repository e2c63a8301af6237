"""From USD files to triangles."""
