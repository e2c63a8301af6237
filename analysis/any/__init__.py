"""What is known of runs of any form, by the keys that all steps have: what a form adds stands in its own room."""
