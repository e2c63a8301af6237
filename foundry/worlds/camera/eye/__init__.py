"""What the agent sees, and the views from above."""
