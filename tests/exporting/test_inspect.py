"""Logs of Inspect, read and shown by Inspect itself."""

from __future__ import annotations

import base64
import hashlib
import shutil
import zipfile
from pathlib import Path
from typing import Any

import msgspec
import pytest

from exporting.conftest import MADE_UP, THOUGHT, exported
from foundry.exporting.writing import ExportedRun, conditions
from foundry.records import Attempt
from foundry.storing.store import SweepFolder

pytestmark = [pytest.mark.exports, pytest.mark.filterwarnings("default")]


def logs(sweep: SweepFolder, *arguments: str) -> list[Any]:
    log = pytest.importorskip("inspect_ai.log", reason="needs the extra inspect: pip install 'foundry-worlds[inspect]'")
    exported("inspect", "out", *arguments, cwd=sweep.path.parent)
    return [log.read_eval_log(str(file), resolve_attachments=True) for file in files(sweep)]


def files(sweep: SweepFolder) -> list[Path]:
    return sorted(sweep.export_dir("inspect").glob("*.eval"))


def log_of(found: list[Any], model: str) -> Any:
    return next(one for one in found if one.eval.model == model)


def calls_in(sample: Any) -> list[Any]:
    return [event for event in sample.events if event.event == "model"]


def test_a_run_is_a_sample_and_a_call_an_event_with_prompt_reply_settings_and_tokens(sweep: SweepFolder):
    found = log_of(logs(sweep), "qwen3:4b")
    recorded = list(sweep.runs()[0].calls())
    sample = found.samples[0]
    assert (found.status, [sample.id for sample in found.samples], sample.metadata["run"]) == (
        "success", [0, 1], sweep.runs()[0].id,
    )  # fmt: skip
    events = calls_in(sample)
    assert [event.input[0].text for event in events] == [call.messages[0]["content"] for call in recorded]
    assert [event.output.completion for event in events] == [call.text for call in recorded]
    assert [event.config.seed for event in events] == [call.seed for call in recorded]
    first, call = events[0], recorded[0]
    assert (first.config.temperature, first.config.max_tokens) == (0.2, 512)
    assert first.metadata["parameters"] == call.parameters and first.working_time == call.timings["latency"]
    assert first.output.choices[0].message.content[0].reasoning == THOUGHT
    assert first.output.stop_reason == "stop"
    usage = sample.model_usage["qwen3:4b"]
    assert (usage.input_tokens, usage.output_tokens) == (300 * len(recorded), 20 * len(recorded))
    assert str(call.host) not in found.model_dump_json()


def test_steps_are_spans(sweep: SweepFolder):
    sample = log_of(logs(sweep), "scripted/random").samples[0]
    assert [event.name for event in sample.events if event.event == "span_begin"] == ["step 1", "step 2"]
    spans = {event.span_id: event.metadata["step"] for event in calls_in(sample)}
    assert list(spans.values()) == [1, 2]


def test_declared_measures_are_scores_with_their_means(sweep: SweepFolder):
    found = log_of(logs(sweep, "--family", "idle_rate.chosen", "--family", "warning.social_reach"), "scripted/random")
    names = ["idle_rate.chosen", "warning.social_reach"]
    assert [scorer.name for scorer in found.eval.scorers] == names
    values = [sample.scores["idle_rate.chosen"].value for sample in found.samples]
    (score,) = found.results.scores
    assert score.metrics["mean"].value == pytest.approx(sum(values) / 2) and score.scored_samples == 2
    unscored = found.samples[0].scores["warning.social_reach"]
    assert unscored.value != unscored.value, "nobody perceived a fire, so the reach is undefined and no zero"


def test_a_mean_has_its_interval_and_says_how_many_runs_have_no_value(sweep: SweepFolder):
    log = pytest.importorskip("foundry.exporting.inspect.log", exc_type=ImportError)
    (score,) = log.eval_log(conditions(sweep)[0], MADE_UP).results.scores
    found = {name: metric.value for name, metric in score.metrics.items()}
    assert found == {"mean": 2.0, "ci_low": 1.0, "ci_high": 4.0, "std": 0.5}
    assert (score.scored_samples, score.unscored_samples) == (1, 1)


def test_a_call_says_its_tries_its_cache_and_why_it_ended(sweep: SweepFolder, monkeypatch: pytest.MonkeyPatch):
    events = pytest.importorskip("foundry.exporting.inspect.log", exc_type=ImportError)
    run = conditions(sweep)[0].runs[0]
    tried = (Attempt(error="busy", elapsed_s=0.5),)
    call = msgspec.structs.replace(next(run.calls()), cached=True, attempts=tried, ending="length", cached_tokens=100)
    monkeypatch.setattr(ExportedRun, "calls", lambda _: iter([call]))
    (event,) = [event for event in events.events(run) if event.event == "model"]
    assert (event.cache, event.retries, event.output.stop_reason) == ("read", 1, "max_tokens")
    usage = event.output.usage
    assert (usage.input_tokens, usage.input_tokens_cache_read, usage.total_tokens) == (200, 100, 320)


def test_a_failed_run_has_its_error_and_no_score(sweep: SweepFolder):
    found = log_of(logs(sweep), "llama3.2")
    assert found.results.completed_samples == 0 and found.results.scores == []
    assert "no more for today" in found.samples[0].error.message and found.samples[0].scores is None


def test_the_same_sweep_gives_the_same_bytes(sweep: SweepFolder, tmp_path: Path):
    logs(sweep)
    exported("inspect", "out", str(tmp_path / "again"), cwd=sweep.path.parent)
    assert len(files(sweep)) == 3
    for file in files(sweep):
        with zipfile.ZipFile(file) as archive:
            assert {member.date_time for member in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    assert [(tmp_path / "again" / file.name).read_bytes() for file in files(sweep)] == [
        file.read_bytes() for file in files(sweep)
    ]


def test_images_are_in_the_log_as_they_were_sent(seen: SweepFolder):
    (sample,) = logs(seen)[0].samples
    (run,) = seen.runs()
    for event, call in zip(calls_in(sample), run.calls(), strict=True):
        text, image = event.input[0].content
        content = base64.b64decode(image.image.partition("base64,")[2])
        assert text.text == call.messages[0]["content"]
        assert hashlib.sha256(content).hexdigest() == call.messages[0]["images_sha256"][0]


def test_an_image_that_was_not_kept_is_told_by_its_hash_and_is_no_text(seen: SweepFolder, tmp_path: Path):
    copy = Path(shutil.copytree(seen.path, tmp_path / "out"))
    shutil.rmtree(next(copy.glob("runs/*/images")))
    (sample,) = logs(SweepFolder.open(copy))[0].samples
    call = next(seen.runs()[0].calls())
    assert calls_in(sample)[0].input[0].content[1].data == {
        "image_sha256": call.messages[0]["images_sha256"][0],
        "kept": False,
    }


def test_runs_that_have_not_ended_are_left_out_and_counted(sweep: SweepFolder, tmp_path: Path):
    copy = SweepFolder.open(shutil.copytree(sweep.path, tmp_path / "out"))
    (copy.runs()[0].path / "run.json").unlink()
    found = log_of(logs(copy), "qwen3:4b")
    assert (found.status, found.results.total_samples, found.results.completed_samples) == ("cancelled", 2, 1)
    told = exported("inspect", "out", str(tmp_path / "again"), cwd=tmp_path)
    assert "cafe_library, qwen3:4b, paper: 1 unfinished runs are left out" in told
