"""Finds problems of a sweep before it starts. These checks record the speed of servers, but no answers."""

from foundry.doctor.examination import Finding, Status, examine

__all__ = ["Finding", "Status", "examine"]
