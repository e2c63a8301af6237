"""A world of the form part_name: put your own world in place of this one."""

from typing import ClassVar

from foundry.worlds.rounds.bar import Bar


class PartName(Bar):
    """The world `bar`, with records of the form part_name."""

    form: ClassVar[str] = "part_name"
