"""A sweep as files of other tools: what was asked, what was answered and what it came to, in their own formats."""
