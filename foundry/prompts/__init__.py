"""Templates that turn an observation into the messages a model is sent."""

from foundry.prompts.prompt import Prompt

__all__ = ["Prompt"]
