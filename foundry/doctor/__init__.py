"""Finds problems of a sweep before it starts. The checks call the servers; their speed is kept, but no answer."""

from foundry.doctor.examination import Finding, Status, examine

__all__ = ["Finding", "Status", "examine"]
