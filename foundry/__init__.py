"""Put different language models into the same small world and measure how differently they behave."""

__version__ = "0.2.0.dev0"
