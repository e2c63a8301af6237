"""Code that all models behind HTTP servers share."""
