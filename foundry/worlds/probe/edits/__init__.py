"""What is changed in what an agent perceives, one module each, by the form of the world that asks."""
