"""Common parts of backends over HTTP."""
