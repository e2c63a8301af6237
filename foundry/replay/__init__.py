"""Pictures, films and a window of finished or running runs, drawn from their records alone."""
