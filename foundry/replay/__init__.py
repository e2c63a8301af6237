"""Pictures, films and a window of runs that are over or still going on, from their records alone."""
