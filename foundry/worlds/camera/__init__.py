"""3D worlds: USD scenes seen and walked through by one agent."""
