"""Shows recorded runs in a browser, from the records alone."""
