"""What would go wrong with a sweep, found before it starts; nothing is written and no answer is kept."""

from foundry.doctor.examination import examine
from foundry.doctor.finding import Finding, Status

__all__ = ["Finding", "Status", "examine"]
