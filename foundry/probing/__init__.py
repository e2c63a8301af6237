"""From recorded sweeps to a probe: the same moments before every model."""
