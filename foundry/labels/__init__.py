"""Labels: questions about the texts of a sweep, answered by a rule, by models and by people."""
