"""The commands that check a user's own parts, and begin new ones."""

import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import EXIT_FAILED, EXIT_INPUT, EXIT_OK, EXTEND, OVERRIDES, app
from foundry.commands.options import AsJson, Mine, Overrides, given
from foundry.commands.printing import console, is_quiet, only_json, print_json, say
from foundry.errors import InputError


@app.command(context_settings=OVERRIDES, rich_help_panel=EXTEND)
def check(
    overrides: Overrides = None,
    known: Annotated[bool, typer.Option("--known", help="Instead, play scripted policies with known results.")] = False,
    write: Annotated[Path | None, typer.Option(help="With --known: write the results into this Markdown file.")] = None,
    json: AsJson = False,
    config_dir: Mine = None,
) -> None:
    """Check your own worlds, prompts, models, edits and signatures.

    The exit code is 2 if a check fails.

    foundry check world=mine prompt=mine --config-dir mine

    foundry check greed world=mine --config-dir mine: check the signature mine/signatures/greed.py on runs of that world

    foundry check --known bar fishery: play policies whose results are known, by default in all worlds; the exit code
    is 3 if a result differs
    """
    if known:
        raise typer.Exit(_check_known(overrides or (), write, json, config_dir or ()))
    if write is not None:
        raise InputError(f"--write {write} only works with --known. Add --known, or leave out --write.")
    raise typer.Exit(_check_parts(given(overrides, config_dir), json))


def _check_parts(asked: Sequence[str], json: bool) -> int:

    from foundry.conformance.checking import check_asked
    from foundry.conformance.playing import failed
    from foundry.display import frame_table

    with only_json(json):
        checks = check_asked(asked)
    if json:
        print_json({"findings": checks})
    else:
        rows = [
            (check.part, check.check, check.status.value, check.note)
            for check in (failed(checks) if is_quiet() else checks)
        ]
        console().print(frame_table(rows, ("of", "check", "status", "note")))
        passed = sum(check.status == "passed" for check in checks)
        print(f"{passed} of {len(checks)} checks passed, {len(failed(checks))} failed")
    return EXIT_INPUT if failed(checks) else EXIT_OK


def _check_known(worlds: Sequence[str], page_file: Path | None, json: bool, config_dir: Sequence[Path]) -> int:

    from analysis.validation.facts import all_facts
    from foundry.display import frame_table
    from foundry.validating.playing import COLUMNS, hold, page, row

    with only_json(json), tempfile.TemporaryDirectory(prefix="foundry-check-") as folder:
        results = [result for facts in all_facts(tuple(worlds)) for result in hold(facts, Path(folder), config_dir)]
    if page_file is not None:
        page_file.write_text(page(results), encoding="utf-8", newline="\n")
    missed = sum(not result.holds for result in results)
    if json:
        print_json({"known": [{**asdict(result), "holds": result.holds} for result in results]})
    else:
        console().print(frame_table(map(row, results), COLUMNS))
        if page_file is not None:
            print(f"wrote {page_file}")
        print(f"{len(results) - missed} of {len(results)} results agree with their known values")
    return EXIT_FAILED if missed else EXIT_OK


@app.command(rich_help_panel=EXTEND)
def new(
    kind: Annotated[str, typer.Argument(help="world, signature, prompt, model, policy, edit or form.")],
    name: Annotated[str, typer.Argument(help="Name of the part, such as market.")],
    into: Annotated[Path, typer.Option("--into", "--config-dir", "-cd", help="The folder of your parts.")] = Path(
        "mine"
    ),
) -> None:
    """Write a new part that runs, with a test.

    foundry new world market, then: foundry --config-dir mine world=market model=scripted/random
    """
    from foundry.composing.beginning import begin

    begun = begin(kind, name, into)
    for file in begun.files:
        print(f"wrote {file}")
    say(f"try it with: {begun.try_it}")
