"""What is known of a world: closed forms that scripted policies must come to, and figures that others published."""
