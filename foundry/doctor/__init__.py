"""Finds problems of a sweep before it starts; records only the speed of servers, and no answers."""

from foundry.doctor.examination import Finding, Status, examine

__all__ = ["Finding", "Status", "examine"]
