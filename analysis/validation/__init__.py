"""Known results of worlds: closed forms for scripted policies, and published figures."""
