"""What would go wrong with a sweep, found before it starts; no answer is kept, but the speed."""

from foundry.doctor.examination import examine
from foundry.doctor.finding import Finding, Status

__all__ = ["Finding", "Status", "examine"]
