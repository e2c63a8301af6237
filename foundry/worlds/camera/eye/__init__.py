"""The agent's view, and views from above."""
