"""Put different language models into the same small world and measure how differently they behave."""

__version__ = "0.1.0"
