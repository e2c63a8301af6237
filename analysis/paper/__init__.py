"""What an analysis says in words: a summary, the methods, what to cite, a card of each model."""
