"""One page about a probe: what each model did in the same moments."""
