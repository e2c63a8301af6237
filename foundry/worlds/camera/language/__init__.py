"""What the interpreter knows of natural language: words, numbers, sentences and what a sentence orders."""
