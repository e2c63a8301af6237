"""A world of a user's own, of a form that nobody knows: what was recorded of it is as good as of any other."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from commands import foundry, records, refusal, statuses, succeeds
from foundry.errors import RecordError
from foundry.storing.store import RunFolder, SweepFolder
from own_market import write_market
from trust.conftest import rewrite, run_of, runs

MARKET = ("--config-dir", "mine", "world=market", "prompt=market")
QUIET = ("analyze=false", "runner.workers=1")
TRUSTED = ("--trust-targets", "market")
STREAMS = ("agents", "prices", "steps")


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(write_market(folder))
        yield folder


@pytest.fixture(scope="module")
def market(home: Path) -> Path:
    succeeds("-m", *MARKET, "model=bidder,miser", "seed=0-1", *QUIET, "output.dir=out", cwd=home)
    return home / "out"


@pytest.fixture
def copied(market: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(market, tmp_path / "copy"))


def lines(run: RunFolder, stream: str) -> list[dict[str, Any]]:
    return [msgspec.json.decode(line) for line in run.stream_path(stream).read_bytes().splitlines()]


def verified(sweep: Path, *options: str) -> Any:
    return foundry("verify", str(sweep), "--workers", "1", *TRUSTED, *options, cwd=sweep.parent)


def test_its_records_say_its_form_and_all_its_streams_are_kept(market: Path):
    for run in runs(market):
        summary = run.summary()
        assert summary.form == "market" == run.declared.form
        assert {f"{name}.jsonl" for name in STREAMS} <= summary.records_sha256.keys()
        assert [line["step"] for line in lines(run, "prices")] == [1, 2, 3, 4]
    assert run.declared.streams["prices"] == {"step": "integer", "paid": "integer", "buyer": "text"}
    done = succeeds("status", str(market), cwd=market.parent)
    assert "bidder" in done.stdout and "failed" not in done.stdout.splitlines()[-1]


def test_it_is_verified_to_the_last_line_of_its_own_stream(market: Path, copied: Path):
    done = verified(market)
    # Three agents, four rounds and one price each; in every other round all talk twice.
    assert done.returncode == 0 and f"4 identical; {4 * (3 + 12 + 12 + 4)} lines" in done.stdout, done.stdout
    assert f"{4 * 24} questions compared" in done.stdout
    file = run_of(copied, "bidder").stream_path("prices")
    file.write_bytes(file.read_bytes().replace(b'"buyer":"', b'"buyer":"9', 1))
    done = verified(copied)
    assert done.returncode == 3 and "differs: prices.jsonl line 1: buyer: recorded '9" in done.stdout, done.stdout
    assert f"{run_of(copied, 'bidder').id} differs" in done.stdout and "3 identical, 1 differs" in done.stdout


def test_two_of_its_runs_are_compared_by_what_all_forms_record(market: Path):
    one, other = run_of(market, "bidder"), run_of(market, "miser")
    done = succeeds("diff", str(one.path), str(other.path), "--json", cwd=market)
    found = msgspec.json.decode(done.stdout)
    first = next(
        place
        for place, line in enumerate(zip(lines(one, "steps"), lines(other, "steps"), strict=True), start=1)
        if (line[0]["action"], line[0]["cash"]) != (line[1]["action"], line[1]["cash"])
    )
    assert found["state"]["number"] == first and found["state"]["place"][2] == "bid"
    assert found["answer"]["place"][2] == "bid" and found["question"]["place"][2] == "bid"
    for row in found["drift"]:
        pairs = [
            pair
            for pair in zip(lines(one, "steps"), lines(other, "steps"), strict=True)
            if pair[0]["step"] == row["step"]
        ]
        assert row["decisions"] == len(pairs) and row["agents"] == 3
        assert row["acted"] == sum(a["action"] != b["action"] for a, b in pairs) / len(pairs)
        assert row["distance"] is None and row["turned"] is None
    table = succeeds("diff", str(one.path), str(other.path), cwd=market)
    assert "acted differently" in table.stdout and "mean distance" not in table.stdout
    done = foundry("diff", str(one.path), str(one.path), cwd=market)
    assert "decisions, places and utilities are equal in all 4 steps that both runs have" in done.stdout


@pytest.mark.slow
def test_it_is_continued_by_another_policy_and_the_past_is_shared(market: Path, tmp_path: Path, home: Path):
    origin = run_of(market, "bidder", 1)
    for at in (3, 4, 5):
        options = (*TRUSTED, "--config-dir", str(home / "mine"), "world.steps=6", "model=miser", *QUIET)
        succeeds("fork", str(origin.path), "--at", str(at), *options, f"output.dir={at}", cwd=tmp_path)
        (run,) = runs(tmp_path / str(at))
        for stream in ("steps", "prices"):
            shared = [line for line in lines(origin, stream) if line["step"] < at]
            assert [line for line in lines(run, stream) if line["step"] < at] == shared
        assert {line["action"] for line in lines(run, "steps") if line["step"] >= at} <= {None, 0}
        assert set(run.config()["fork"]["records_sha256"]) >= {f"{name}.jsonl" for name in STREAMS}
        assert verified(tmp_path / str(at)).returncode == 0
    assert "has 4 steps, so use a step from 2 to 5" in refusal(
        "fork", str(origin.path), "--at", "6", *TRUSTED, *QUIET, cwd=tmp_path
    )


@pytest.mark.slow
def test_its_bundle_holds_all_its_streams_and_goes_on_elsewhere(market: Path, tmp_path: Path):
    succeeds("bundle", str(market), str(tmp_path / "market.tar.zst"), cwd=tmp_path)
    succeeds("unbundle", "market.tar.zst", "anew", cwd=tmp_path)
    anew = tmp_path / "anew"
    assert [run.declared for run in runs(anew)] == [run.declared for run in runs(market)]
    for run, origin in zip(runs(anew), runs(market), strict=True):
        for stream in STREAMS:
            assert run.stream_path(stream).read_bytes() == origin.stream_path(stream).read_bytes()
    assert verified(anew).returncode == 0
    assert "--trust-targets market" in refusal("verify", "anew", cwd=tmp_path)
    kept = records(anew)
    shutil.rmtree(runs(anew)[0].path)
    killed = runs(anew)[1]
    (killed.path / "run.json").unlink()
    killed.stream_path("prices").write_bytes(killed.stream_path("prices").read_bytes()[:-9])
    assert "2 identical, 2 missing" in verified(anew).stdout
    done = succeeds("resume", "anew", *TRUSTED, cwd=tmp_path)
    assert statuses(anew) == ["complete"] * 4, done.stdout + done.stderr
    assert records(anew) == kept and verified(anew).returncode == 0


def test_a_record_that_it_did_not_declare_ends_the_run_alone_and_says_why(home: Path, tmp_path: Path):
    options = ("model=bidder", "seed=0-2", "world.leaky=[1]", *QUIET, f"output.dir={tmp_path / 'out'}")
    done = foundry("-m", *MARKET, *options, cwd=home)
    assert done.returncode == 3 and "Traceback" not in done.stderr
    assert statuses(tmp_path / "out") == ["complete", "failed", "complete"]
    summary = runs(tmp_path / "out")[1].summary()
    assert summary.error is not None and summary.traceback is None
    assert summary.error.startswith(
        "the world wrote a record of stream 'rumours', which it does not declare. Declared are"
    )
    assert "failed" in done.stdout and "'rumours'" in done.stdout
    assert not runs(tmp_path / "out")[1].path.joinpath("rumours.jsonl").exists()
    told = verified(tmp_path / "out")
    assert "failed after 2 steps: the world wrote a record of stream 'rumours'" in told.stdout, told.stdout


NO_NAME = "is not a valid name of a form or a record file"


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        (("streams", "../../x"), {}, f"'../../x' {NO_NAME}"),
        (("streams", "calls"), {}, f"'calls' {NO_NAME}"),
        (("streams", "A.B"), {}, f"'A.B' {NO_NAME}"),
        (("form",), "/etc/passwd", f"'/etc/passwd' {NO_NAME}"),
        (("form",), "x" * 41, NO_NAME),
        (("form",), 3, "Expected `str`, got `int`"),
        (("actions",), [1], "Expected `object`, got `array`"),
        (("streams", "steps"), ["step"], "Expected `object`, got `array`"),
        (("streams", "steps", "cash"), 3, "Expected `str`, got `int`"),
        (("actions", "bid"), {"low": "much"}, "got `str`"),
    ],
)
def test_what_a_foreign_sweep_declares_is_refused_in_one_line_where_it_is_no_declaration(
    place: tuple[str, ...], value: object, said: str, copied: Path
):
    def put(content: dict[str, Any]) -> None:
        inner = content["conditions"][0]["declared"]
        for key in place[:-1]:
            inner = inner[key]
        inner[place[-1]] = value

    rewrite(copied, put)
    with pytest.raises(RecordError) as caught:
        SweepFolder.open(copied)
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_no_command_reads_a_sweep_that_declares_no_form(copied: Path):
    rewrite(copied, lambda content: content["conditions"][0]["declared"].pop("form"))
    run = str(next((copied / "runs").iterdir()))
    for command in (("status", "copy"), ("verify", "copy"), ("resume", "copy"), ("diff", run, run), ("analyze", "copy"),
                    ("bundle", "copy", "x.tar.zst"), ("fork", run, "--at", "2")):  # fmt: skip
        assert "missing required field `form`" in refusal(*command, cwd=copied.parent)


def test_what_a_sweep_declares_is_held_against_what_its_world_says(copied: Path):
    rewrite(copied, lambda content: content["conditions"][0]["declared"]["actions"]["bid"].update(high=11.0))
    rewrite(copied, lambda content: content["conditions"][1]["declared"].update(form="bazaar"))
    done = verified(copied)
    assert done.returncode == 3 and "4 runs: 4 differs" in done.stdout, done.stdout
    assert "differs: sweep.yaml: declared.actions.bid.high: recorded 11.0, now 10" in done.stdout
    assert "differs: sweep.yaml: declared.form: recorded 'bazaar', now 'market'" in done.stdout
    assert "records of world 'market' have changed since this sweep began" in refusal(
        "resume", "copy", *TRUSTED, cwd=copied.parent
    )


def test_another_form_than_a_shipped_class_has_is_refused_before_anything_is_read(grid_sweep: Path, tmp_path: Path):
    copy = Path(shutil.copytree(grid_sweep, tmp_path / "copy"))
    rewrite(copy, lambda content: content["conditions"][0]["declared"].update(form="camera"))
    for command in ("status", "verify", "resume", "analyze", "report"):
        line = refusal(command, "copy", cwd=tmp_path)
        assert (
            "the form is 'camera', but the records of foundry.worlds.grid.grid_world.GridScenario have the form" in line
        )


def test_records_that_are_not_of_the_form_that_a_sweep_says_are_not_compared(copied: Path):
    rewrite(copied, lambda content: [one["declared"].update(form="camera") for one in content["conditions"]])
    one, other = (str(run_of(copied, model).path) for model in ("bidder", "miser"))
    assert "do not have the form 'camera', which their sweep declares (KeyError: 'pose')" in refusal(
        "diff", one, other, cwd=copied
    )
