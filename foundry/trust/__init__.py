"""What a recorded sweep is good for later: verifying, comparing, continuing and handing on."""
