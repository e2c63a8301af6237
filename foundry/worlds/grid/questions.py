"""The kinds of question of a 2D world, and the replies that do nothing."""

from __future__ import annotations

import json

MESSAGE, ACTION = "message", "action"
IDLE = {
    MESSAGE: json.dumps({"message": None, "reasoning": "I keep to myself."}),
    ACTION: json.dumps({"action": "stay", "memory": "", "reasoning": "I stay where I am."}),
}
"""The replies that do nothing."""
