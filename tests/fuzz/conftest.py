"""How long the fuzzing is: a glance in the normal suite, the whole with `pytest -m exhaustive tests/fuzz -s`."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

CHECKS = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.function_scoped_fixture]
settings.register_profile("fuzz", deadline=None, derandomize=True, database=None, suppress_health_check=CHECKS)
