"""The command that puts every model before the same recorded moments."""

from __future__ import annotations

import itertools
import tempfile
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import EXIT_OK, OVERRIDES, Trusted, TrustedServers, app
from foundry.commands.sweeps import reached_now, run_checked
from foundry.commands.view import check_view


@app.command(context_settings=OVERRIDES)
def probe(
    context: typer.Context,
    sweep: Annotated[Path, typer.Argument(help="A sweep's folder; further ones may follow.", show_default=False)],
    trust_targets: Trusted = None,
    trust_servers: TrustedServers = False,
) -> None:
    """Ask every model in the same recorded moments: what does each do, and what makes it do otherwise?

    foundry probe outputs/pilot -m model=qwen3:4b,llama3.2 edit=none,no_fire,mirror

    Beside the overrides of a sweep it takes

    moments=300: how many recorded questions, or the moments.json of an earlier probe;
    moments_seed=0: what they are drawn by;
    repeats=10: how often each is asked, each time with a sampling seed of its own;
    edit=none: what is changed in what the agents perceive, such as no_fire,mirror; also of mine/edits/.
    """
    from foundry.composing.preparing import checked
    from foundry.probing.composing import compose_probe
    from foundry.storing.store import SweepFolder
    from foundry.trust import reaching
    from foundry.trust.targets import check_sweep_targets

    further = list(itertools.takewhile(lambda one: "=" not in one and not one.startswith("-"), context.args))
    arguments = context.args[len(further) :]
    sweeps = [SweepFolder.open(path) for path in (sweep, *map(Path, further))]
    for one in sweeps:
        check_sweep_targets(one.sweep, one.settings, trust_targets or ())
        one.sweep = reached_now(one.sweep)
    found = compose_probe(sweeps, arguments)
    if found is None:
        raise typer.Exit(EXIT_OK)
    if not trust_servers:
        models = [condition.config["model"] for condition in found.composed.conditions]
        reaching.check_models(models, typed=arguments, recorded=sweeps[0].runs()[0].config()["model"])
    check_view(found.composed.settings["view"])
    with tempfile.TemporaryDirectory() as scratch:
        ready = checked(found.composed, partial(found.placed, Path(scratch)))
    print(found.asked)
    raise typer.Exit(run_checked(ready, found.keep))
