"""Models with weights in this process."""
