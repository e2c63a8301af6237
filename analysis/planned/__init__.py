"""What was declared before the runs, and how often data were looked at that nothing was declared of."""
