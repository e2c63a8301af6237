"""Every command that reads the folder `out` of a sweep."""

from pathlib import Path

COMMANDS = {
    "status": "status out",
    "verify": "verify out --workers 1",
    "diff": "diff RUN RUN",
    "fork": "fork RUN --at 2 analyze=false output.dir=forked",
    "bundle": "bundle out out.tar.zst",
    "analyze": "analyze out",
    "report": "report out",
    "view": "view out --export page",
    "replay": "replay RUN --steps 1",
    "label": "label out --model scripted/stay",
    "probe": "probe out moments=1 repeats=1 model=scripted/stay output.dir=again",
    "resume": "resume out",
}
"""Commands by name; RUN stands for the folder of a run."""


def words(command: str, run: Path) -> list[str]:
    return command.replace("RUN", str(run)).split()
