"""The same recorded moments before every model: what is known of scripted policies in closed form comes out."""

import hashlib
import math
import shutil
from collections import Counter
from pathlib import Path
from typing import Any

import msgspec
import pandas as pd
import pytest

from analysis.paper.summary import EXPLORES
from analysis.probes.probe_tables import analyze_probe
from commands import cached_answers, foundry, kill, started, wait_until
from foundry.storing.standing import unread
from foundry.storing.store import SweepFolder
from foundry.worlds.probe.moments import Moments
from holding import Holding
from ollama_cases import Body
from ollama_server import OllamaServer
from probing.conftest import MOMENTS, QUIET, REPEATS, WORLD, done, lines, refused, runs

TRUSTED = ("--trust-targets", "policies")


def moments_in(path: Path) -> Moments:
    return msgspec.json.decode((path / "moments.json").read_bytes(), type=Moments)


def table(path: Path, name: str, **wanted: str) -> pd.DataFrame:
    frame = pd.read_csv(path / "analysis" / f"{name}.csv", keep_default_na=False, na_values=[""])
    for column, value in wanted.items():
        frame = frame[frame[column] == value]
    return frame


def shares(path: Path, model: str, edit: str) -> dict[tuple[Any, ...], dict[str, int]]:
    found: dict[tuple[Any, ...], dict[str, int]] = {}
    for row in table(path, "moments", model=model, edit=edit).to_dict("records"):
        key = tuple(row[name] for name in ("run", "step", "agent", "kind"))
        found.setdefault(key, {})[row["choice"]] = row["count"]
    return found


def test_a_probe_asks_in_the_moments_as_they_were_recorded(pilot: Path, probed: Path):
    recorded = {
        (run.id, call.step, call.agent, call.kind): (call.messages, call.seed)
        for run in runs(pilot)
        for call in run.calls()
    }
    moments = moments_in(probed)
    assert len(moments.moments) == len(set(moments.moments)) == MOMENTS
    for run in runs(probed):
        if run.config()["world"]["edit"]["name"] == "none":
            asked = list(zip(lines(run), run.calls(), strict=True))
            assert len(asked) == REPEATS * sum(len(moments) for moments in moments.of(run.run.seed).values())
            for line, call in asked:
                messages, seed = recorded[line["run"], line["step"], line["agent"], line["kind"]]
                assert call.messages == messages and (call.seed == seed) == (line["repeat"] == 0)


def test_what_the_world_tells_moments_apart_by_stands_beside_every_choice(probed: Path):
    moments = moments_in(probed)
    assert [set(one) for one in moments.strata] == [{"fire", "message", "wall"}] * MOMENTS
    frame = table(probed, "moments", model="scripted/herd", edit="none")
    told = {(row["run"], row["step"], row["agent"], row["kind"]): row["fire"] for row in frame.to_dict("records")}
    by_moment = zip(moments.moments, moments.strata, strict=True)
    assert told == {
        (moment.run, moment.step, moment.agent, moment.kind): strata["fire"] for moment, strata in by_moment
    }
    assert set(told.values()) == {True, False}


def test_who_reads_fires_alone_changes_without_them_and_who_reads_none_does_not(pilot: Path, probed: Path):
    perceived = {(run.id, line["step"], line["agent"]): line for run in runs(pilot) for line in lines(run)}
    avoid = shares(probed, "scripted/avoid", "none"), shares(probed, "scripted/avoid", "no_fire")
    known = {one for one in avoid[0] if perceived[one[:3]]["fires"]}
    assert 0 < len(known) < MOMENTS
    assert set(avoid[1]) == set(shares(probed, "scripted/herd", "no_fire")) == known
    changed = {one for one in avoid[1] if avoid[0][one] != avoid[1][one]}
    warned = {one for one in avoid[1] if one[3] == "message" and perceived[one[:3]]["neighbours"]}
    fled = {one for one in avoid[1] if one[3] == "action"}
    assert warned and fled and changed == warned | fled
    for one in warned:
        assert (avoid[0][one], avoid[1][one]) == ({"speaks": REPEATS}, {"is silent": REPEATS})
    herd = shares(probed, "scripted/herd", "none"), shares(probed, "scripted/herd", "no_fire")
    assert all(herd[0][one] == herd[1][one] for one in herd[1])
    (row,) = table(probed, "edits", model="scripted/herd", edit="no_fire", kind="all").to_dict("records")
    assert row["distance"] == 0 and row["standing_out"] == 0
    (row,) = table(probed, "edits", model="scripted/avoid", edit="no_fire", kind="all").to_dict("records")
    assert row["excess"] > 0.1 and (row["seeds"], row["p"]) == (3, pytest.approx(math.nan, nan_ok=True))


def test_who_always_goes_left_is_wrong_in_a_mirror_and_a_model_by_another_name_does_not_differ(probed: Path):
    rows = table(probed, "edits", model="left", edit="mirror").set_index("kind")
    assert rows["leaves"].unique().tolist() == ["equivariance"] and rows.loc["all", "moments"] == MOMENTS
    assert rows.loc["action", "distance"] == 1 and rows.loc["message", "distance"] == 0
    pairs = table(probed, "agreement", kind="all").set_index(["first", "second"])
    assert len(pairs) == 10
    (same,) = pairs[(pairs.index == ("other", "scripted/random"))].to_dict("records")
    assert same["distance"] == 0


@pytest.mark.slow
def test_the_same_moments_can_be_given_again_and_are_verified_and_handed_on(pilot: Path, probed: Path, tmp_path: Path):
    given = f"moments={probed / 'moments.json'}"
    done("probe", str(pilot), "model=scripted/stay", given, "repeats=1", "output.dir=out", *QUIET, cwd=tmp_path)
    assert (tmp_path / "out" / "moments.json").read_bytes() == (probed / "moments.json").read_bytes()
    shutil.copytree(tmp_path / "out", tmp_path / "moved")
    shutil.rmtree(tmp_path / "out")
    assert "3 identical" in done("verify", "moved", "--workers", "1", cwd=tmp_path)
    done("bundle", "moved", "moved.tar.zst", cwd=tmp_path)
    done("unbundle", "moved.tar.zst", "again", cwd=tmp_path)
    assert "3 identical" in done("verify", "again", "--workers", "1", cwd=tmp_path)
    assert "repeats=1" in done("analyze", "again", cwd=tmp_path)


def test_what_was_kept_is_held_against_what_the_probe_was_made_of(probed: Path, tmp_path: Path):
    for name, message in (("moments.json", "its moments differ"), ("origins", "its answers differ")):
        shutil.copytree(probed, tmp_path / name)
        file = tmp_path / name / name
        if file.is_dir():
            files = sorted(file.iterdir())
            files[0].write_bytes(files[1].read_bytes())
        else:
            file.write_bytes(file.read_bytes().replace(b'"action"', b'"message"', 1))
        assert message in refused("verify", name, "--workers", "1", *TRUSTED, cwd=tmp_path)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("model=scripted/stay edit=no_fires", "Did you mean 'no_fire'?"),
        ("model=scripted/stay repeats=0", "repeats must be a whole number from 1; got '0'"),
        ("model=scripted/stay moments=many", "moments=many is not a file"),
        ("model=scripted/stay world.agents=3", "A probe asks in recorded moments, which world.agents= would change"),
        ("model=scripted/stay seed=3", "which seed= would change"),
        ("nowhere model=scripted/stay", "'nowhere' does not exist"),
        ("model=scripted/stay sweep_over=fires.0.distnce=1..3", "Did you mean 'fires.0.distance'?"),
        ("model=scripted/stay format=0-1", "has several values. Add -m"),
        pytest.param("-m model=scripted/stay format=spred/0", "Did you mean 'spread'?", marks=pytest.mark.slow),
        pytest.param("-m model=scripted/stay format=spread", "is a space of formats", marks=pytest.mark.slow),
        ("-m model=scripted/stay format=3-1", "begins with the larger number"),
        ("", "The recorded runs have several models (scripted/herd, scripted/avoid): choose one with model="),
    ],
)
def test_what_cannot_be_probed_is_refused_in_one_line(arguments: str, expected: str, pilot: Path):
    assert expected in refused("probe", "pilot", *arguments.split(), "output.dir=refused", cwd=pilot.parent)
    assert not (pilot.parent / "refused").exists()


def test_a_probe_of_a_probe_or_of_several_worlds_is_refused(pilot: Path, probed: Path, tmp_path: Path):
    assert "itself a probe" in refused("probe", str(probed), *TRUSTED, cwd=tmp_path)
    done("model=scripted/stay", *WORLD, "world.agents=3", *QUIET, "output.dir=other", cwd=tmp_path)
    several = "several worlds (cafe_library with agents 3 and 4): name a sweep with only one world."
    assert several in refused("probe", "other", str(pilot), cwd=tmp_path)


@pytest.mark.slow
def test_moments_and_whole_runs_never_share_a_folder(pilot: Path, tmp_path: Path):
    shutil.copytree(pilot, tmp_path / "pilot")
    once = ("probe", "pilot", "model=scripted/stay", "moments=1", "repeats=1", *QUIET)
    assert "and a probe cannot be added to it" in refused(*once, "output.dir=pilot", cwd=tmp_path)
    assert not (tmp_path / "pilot" / "moments.json").exists()
    told = done(*once, "output.dir=probed", cwd=tmp_path)
    assert "1 moment of 1 run, 1 condition, 1 repeat: at most 1 call, fewer" in told
    whole = ("model=scripted/stay", *WORLD, *QUIET, "output.dir=probed")
    assert "The folder contains a probe, and whole runs" in refused(*whole, cwd=tmp_path)


@pytest.mark.slow
def test_an_edit_of_ones_own_is_found_beside_the_configuration(pilot: Path, tmp_path: Path):
    edits = {"wrong": "{}", "mine": "replace(question, observation={**question.observation, 'neighbours': []})"}
    for folder, edited in edits.items():
        (tmp_path / folder / "edits").mkdir(parents=True)
        (tmp_path / folder / "edits" / "alone.py").write_text(
            "from dataclasses import replace\nNAME, LEAVES = 'alone', 'cause'\n"
            f"def edit(question):\n    return {edited}\n"
        )
    asked = ("model=scripted/stay", "edit=alone", "moments=2", "runner.workers=1", "output.dir=out")
    command = ("probe", str(pilot), *asked)
    failed = foundry(*command, "--config-dir", "wrong", cwd=tmp_path)
    assert "wrong/edits/alone.py cannot edit a '" in failed.stderr + failed.stdout
    done(*command, "--config-dir", "mine", cwd=tmp_path)
    assert "alone" in set(table(tmp_path / "out", "edits")["edit"])


@pytest.mark.parametrize(
    ("option", "expected"),
    [
        ("--baselines", "Name the policies among its models"),
        ("--margin=x=1", "takes no margins"),
        ("--family=no_fires", "Did you mean 'no_fire'"),
        ("--only=edit=no_fires", "Did you mean 'no_fire'"),
        ("--without=edits=mirror", "Did you mean 'edit'"),
        ("--without=seed=0-2", "selects none of "),
    ],
)
def test_what_a_probe_has_not_is_refused(option: str, expected: str, probed: Path):
    assert expected in refused("analyze", str(probed), option, cwd=probed.parent)


@pytest.mark.slow
def test_a_part_of_a_probe_is_analysed_and_every_table_says_so(probed: Path, tmp_path: Path):
    shutil.copytree(probed, tmp_path / "part")
    filters = ("--only", "edit=no_fire", "--only", "fire=true", "--without", "model=left")
    told = done("analyze", "part", *filters, cwd=tmp_path)
    whole, part = table(probed, "moments"), table(tmp_path / "part", "moments")
    taken = whole[(whole["edit"] != "mirror") & whole["fire"] & (whole["model"] != "left")]
    assert len(part) == len(taken) > 0 and part["count"].sum() == taken["count"].sum()
    said = f"only edit=no_fire; only fire=true; without model=left: {taken['count'].sum():,} of "
    assert f"only a part of the answers, {said}" in " ".join(told.split())
    assert set(table(tmp_path / "part", "edits")["edit"]) == {"no_fire"}
    assert table(tmp_path / "part", "agreement")["filter"].str.startswith(said).all()
    analyze_probe(SweepFolder.open(tmp_path / "part"), plots=False)
    assert "filter" not in table(tmp_path / "part", "edits")


STATION = ("world=kibo", "world.camera.width=64", "world.camera.height=48", "world.steps=4")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("world", "model", "edit"),
    [
        (WORLD, "qwen3:4b", "no_fire"),
        pytest.param(STATION, "qwen2.5vl:3b", "mirror_image", marks=pytest.mark.exhaustive),
    ],
)
def test_a_probe_that_is_killed_goes_on_and_pays_for_nothing_twice(
    world: tuple[str, ...], model: str, edit: str, tmp_path: Path
):
    with OllamaServer() as server:
        source = ("-m", f"model={model}", "seed=0-1", *world, *QUIET, "output.dir=pilot")
        done(*source, cwd=tmp_path, OLLAMA_HOST=server.url)
        free = sum(server.answered.values())
    holding = Holding(9)
    arguments = ("probe", "pilot", "moments=8", "repeats=3", "window=1", f"edit={edit}", *QUIET, "output.dir=out")
    with OllamaServer(holding) as server:
        with started(*arguments, cwd=tmp_path, OLLAMA_HOST=server.url) as process:
            wait_until(lambda: holding.held, "the calls are held back", process)
            cache = tmp_path / "outputs" / "answers.sqlite"
            wait_until(lambda: cached_answers(cache) == free + 9, "every answer given is in the cache")
            kill(process.pid)
        holding.free()
        done("resume", "out", cwd=tmp_path)
        edited = sum(len(lines(run)) for run in runs(tmp_path / "out") if run.factors["edit"] == edit)
        assert set(server.answered.values()) == {1}
        assert sum(server.answered.values()) == 8 * 2 + edited  # the first repeat is the free run's own answer
    assert "4 identical" in done("verify", "out", "--workers", "1", cwd=tmp_path)


@pytest.mark.slow
def test_the_end_of_a_probe_tells_with_which_edit_replies_could_not_be_read(pilot: Path, tmp_path: Path):
    def reader_of_fires(body: Body) -> str:
        return '{"action": "stay", "reasoning": "r"}' if "great" in str(body["messages"]) else "no idea"

    asked = ("model=qwen3:4b", "edit=no_fire", "moments=20", "repeats=1", *QUIET, "output.dir=out")
    with OllamaServer(reader_of_fires) as server:
        told = done("probe", str(pilot), "-m", *asked, cwd=tmp_path, OLLAMA_HOST=server.url)
    (unread_of_model,) = unread(SweepFolder.open(tmp_path / "out").runs())
    assert list(unread_of_model.share_by_part)[0] == "edit no_fire" and unread_of_model.share_by_part["edit none"] < 1
    assert "  edit no_fire: 100.0%; edit none: " in told


ASKED = ("-m", "model=scripted/herd,scripted/avoid", "edit=no_fire,mirror", "moments=20", "repeats=2")


@pytest.mark.slow
def test_a_plan_counts_the_calls_that_the_probe_then_makes(pilot: Path, tmp_path: Path):
    told = done("probe", str(pilot), "--plan", *ASKED, "output.dir=out", cwd=tmp_path)
    rows = [line.split() for line in told.splitlines()]
    assert rows[0] == ["edit", "moments", "conditions", "calls"] and not list(tmp_path.iterdir())
    done("probe", str(pilot), *ASKED, "output.dir=out", *QUIET, cwd=tmp_path)
    made = Counter[str]()
    for run in runs(tmp_path / "out"):
        made[run.factors["edit"]] += len(lines(run))
    planned = {edit: (int(moments), conditions, int(calls)) for edit, moments, conditions, calls in rows[1:4]}
    assert planned == {edit: (calls // 4, "2", calls) for edit, calls in made.items()}
    assert made["no_fire"] < made["none"] == made["mirror"] == 80
    fewer = "fewer if an edit does not change every moment"
    assert f"at most 240 calls, {fewer}; with these edits, calls: {made.total()}" in told


def test_a_pilot_probe_says_how_many_seeds_are_needed(probed: Path):
    told = done("plan", "--pilot", str(probed), "--difference", "0.2", "--measure", "no_fire", cwd=probed.parent)
    rows = pd.read_csv(probed / "analysis" / "power.csv").set_index("context")
    assert set(rows.index) == {
        f"model={one}" for one in ("left", "other", "scripted/avoid", "scripted/herd", "scripted/random")
    }
    avoid = rows.loc["model=scripted/avoid"]
    assert (avoid["measure"], avoid["n_pairs"], avoid["difference"]) == ("change under no_fire", 3, 0.2)
    assert avoid["n_family"] >= 6 and "no_fire - none (model=scripted/avoid): play " in told
    every = done("plan", "--pilot", str(probed), "--difference", "0.2", cwd=probed.parent)
    family = pd.read_csv(probed / "analysis" / "power.csv")["family"]
    assert family.min() < family.max()
    assert f"after correction for {family.min()} to {family.max()} tests." in every


ASKED_ONCE = ("-m", "model=scripted/herd,scripted/avoid", "edit=no_fire", "moments=6", "repeats=1", "output.dir=out")


@pytest.mark.slow
def test_a_probe_that_was_declared_is_held_against_its_plan(pilot: Path, tmp_path: Path):
    asked = (str(pilot), *ASKED_ONCE)
    said = done("preregister", *asked, "--family", "no_fire", cwd=tmp_path).splitlines()
    plan = (tmp_path / "out" / "preregistration.yaml").read_bytes()
    assert said[0] == f"{hashlib.sha256(plan).hexdigest()}  out/preregistration.yaml"
    assert said[1] == "3 seeds, tests: 2 of edits" and said[-1].endswith(f"then: foundry probe {' '.join(asked)}")
    assert not any("known before" in line for line in said)
    done("probe", *asked, *QUIET, cwd=tmp_path)
    assert analyze_probe(SweepFolder.open(tmp_path / "out"), plots=False).planned
    again = [word.replace("=out", "=again") for word in asked]
    said = done("preregister", *again, "--family", "no_fire", cwd=tmp_path).splitlines()
    assert said[2].startswith("already recorded before the plan: runs in out; to ask in other moments, ")
    told = " ".join(done("probe", *again, cwd=tmp_path).split())
    assert "nothing differs from the plan" in told and "already recorded before the plan: runs in out" in told
    assert EXPLORES not in told
    assert "foundry resume" not in told, "a probe gets seeds from the sweeps that its moments come from"
    assert "leave --family and --margin out" in refused("analyze", "again", "--family", "no_fire", cwd=tmp_path)
    (tmp_path / "out" / "preregistration.yaml").write_bytes(plan + b"# later\n")
    changed = analyze_probe(SweepFolder.open(tmp_path / "out"), plots=False)
    assert not changed.planned and "does not count as a plan, so all findings are exploratory" in " ".join(
        changed.notes
    )


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ((), "Nothing is declared: name a model or an edit"),
        (("--family", "no_fir"), "Did you mean 'no_fire'?"),
        (("--family", "no_fire", "--looks", "6,8"), "A probe has no margins and no interim looks"),
    ],
)
def test_a_plan_of_a_probe_that_cannot_be_is_refused(pilot: Path, tmp_path: Path, more: tuple[str, ...], message: str):
    assert message in refused("preregister", str(pilot), *ASKED_ONCE, *more, cwd=tmp_path)
    assert not (tmp_path / "out").exists()
