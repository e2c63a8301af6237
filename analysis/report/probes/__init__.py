"""One page about a probe: each model's answers in the same moments."""
