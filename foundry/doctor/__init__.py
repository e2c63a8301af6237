"""Finds problems of a sweep before it starts; it records only the speed, and no answers."""

from foundry.doctor.examination import Finding, Status, examine

__all__ = ["Finding", "Status", "examine"]
