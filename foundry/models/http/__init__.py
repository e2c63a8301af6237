"""The parts that all backends over HTTP share."""
