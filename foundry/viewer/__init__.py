"""Shows what happened in recorded runs, in a browser; reads the records alone."""
