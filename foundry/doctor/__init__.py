"""What would go wrong with a sweep, found before it starts; no answer is kept, but the speed."""

from foundry.doctor.examination import Finding, Status, examine

__all__ = ["Finding", "Status", "examine"]
