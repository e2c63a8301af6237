"""Checks the files `run.json` and `config.yaml` of a replayed run, and compares pictures of two renderers."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec

from foundry.canary import Canary, Distance, Verdict
from foundry.declared import Declared
from foundry.errors import RecordError
from foundry.expansion import identity
from foundry.records import NOT_JSON, Call, Counts, RunSummary
from foundry.running.recorded import CALLS, NOTHING, Departed, Difference, first_difference
from foundry.storing.matching import place_of
from foundry.storing.plain import load_plain, plain
from foundry.storing.run_files import sha256_of
from foundry.storing.store import KEPT, SWEEP_FILE, RunFolder, stored_picture

COMPLETE = "complete"
_NOT_REPLAYED = ("cached", "retries", "model_s")
"""Counts that a replay cannot check, because they depend on where the answers came from."""
_RENDERER = "renderer"
"""The key of a recorded line that names the renderer of the picture."""


def check_summary(config: Mapping[str, Any], summary: RunSummary | None, counts: Counts, calls: Sequence[Call]) -> None:
    """Check that `run.json` of a complete run matches the run's configuration, records and calls."""
    if summary is None or summary.status != COMPLETE:
        return
    names = {part: config[part]["name"] for part in ("world", "model", "prompt")}
    now = {**names, "seed": config["seed"], "sampling_seed": config["sampling_seed"]}
    then = {key: getattr(summary, key) for key in now}
    _check("run.json", then, now)
    _check("run.json", {"counts": _replayed(summary.counts)}, {"counts": _replayed(counts)})
    members = _member_names(config["model"].get("members"))
    _check("run.json", {"members": [member.model for member in summary.members]}, {"members": members})
    step = max((call.step for call in calls), default=0)
    for call in calls:
        if call.step == step:
            _check_answerer(summary, call)


def _member_names(members: Any) -> list[Any]:
    if not isinstance(members, Mapping):
        return []
    models = [member.get("model") for member in members.values() if isinstance(member, Mapping)]
    return [model.get("name") for model in models if isinstance(model, Mapping)]


def check_config(run: RunFolder, config: Mapping[str, Any], summary: RunSummary | None) -> None:
    """Check that `config.yaml` of an ended run equals the run's configuration in the sweep; servers may differ."""
    if summary is None:
        return
    try:
        recorded = load_plain(plain(run.path / "config.yaml").read_text(encoding="utf-8"), "config.yaml")
        then = {**identity(recorded), "seed": recorded.get("seed")}
    except (FileNotFoundError, RecordError, TypeError, AttributeError, UnicodeDecodeError) as error:
        raise Departed(Difference("config.yaml", None, "", f"unreadable: {error}", "the run's settings")) from error
    _check("config.yaml", then, {**identity(config), "seed": config["seed"]})


def check_declared(run: RunFolder, now: Declared, summary: RunSummary | None) -> None:
    """Check that the recorded declaration of records equals the declaration that the world makes now."""
    if run.declared_then is not None:
        then = msgspec.to_builtins(run.declared_then)
        _check(SWEEP_FILE, {"declared": then}, {"declared": msgspec.to_builtins(now)})
    if summary is not None and summary.form is not None:
        _check("run.json", {"form": summary.form}, {"form": now.form})


def check_digests(run: RunFolder, summary: RunSummary | None) -> None:
    """Check that the record files have the digests in `run.json`."""
    # A crashed worker could not record the digests of its files.
    if summary is None or (summary.status != COMPLETE and not summary.records_sha256):
        return
    for stream in run.streams:
        name, path = f"{stream}.jsonl", run.stream_path(stream)
        now = sha256_of(path.read_bytes()) if path.exists() else NOTHING
        recorded = summary.records_sha256.get(name, NOTHING)
        if recorded != now:
            raise Departed(Difference("run.json", None, f"records_sha256.{name}", recorded, now))


def _replayed(counts: Counts) -> dict[str, Any]:
    return {key: value for key, value in msgspec.to_builtins(counts).items() if key not in _NOT_REPLAYED}


def _check_answerer(summary: RunSummary, call: Call) -> None:
    """Check that the right model answered a call of the last step; a replayed model is not checked."""
    place = place_of(call)
    digests = {member.model: member.digest for member in summary.members} or {summary.model: summary.model_digest}
    if call.model not in digests:
        return
    if call.digest != digests[call.model]:
        raise Departed(Difference("run.json", None, "digest", digests[call.model], call.digest, place))
    answering = [member.model for member in summary.members if call.agent in member.agents]
    if summary.members and answering != [call.model]:
        raise Departed(Difference("run.json", None, "members", answering, [call.model], place))


def _check(file: str, then: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    difference = first_difference(then, now)
    if difference is not None:
        raise Departed(Difference(file, None, *difference))


@dataclass(frozen=True)
class Renderers:
    """The names of two different renderers: in the records, and on this machine."""

    then: str
    now: str


def renderers_of(recorded: bytes | None, now: bytes) -> Renderers | None:
    """Return the recorded and the current renderer, if two lines only differ in the renderer; else None."""
    try:
        then, fresh = msgspec.json.decode(recorded or b"null"), msgspec.json.decode(now)
    except NOT_JSON:
        return None
    if not (
        isinstance(then, Mapping) and isinstance(fresh, Mapping) and {**then, _RENDERER: ""} == {**fresh, _RENDERER: ""}
    ):
        return None
    drew, draws = then.get(_RENDERER), fresh.get(_RENDERER)
    return Renderers(drew, draws) if drew != draws and isinstance(drew, str) and isinstance(draws, str) else None


def is_of_pictures(difference: Difference) -> bool:
    """Return whether a difference concerns a picture, such as an image in a question."""
    is_question = difference.file == CALLS and ".images_sha256[" in difference.field
    return is_question or difference.file.split("/")[0] in KEPT


def departed_note(run: RunFolder, drew: Renderers, difference: Difference, drawn: Iterable[bytes]) -> str | None:
    """Return a note about a run that another renderer drew; None if its first differing picture shows other content."""
    from foundry.worlds.camera.eye.likeness import likeness_of

    note = f"was drawn by {drew.then}. Here, {drew.now} draws other pixels, so the run cannot be verified here"
    now = next((content for content in drawn if sha256_of(content) == difference.now), None)
    then = _stored_content(run, difference.recorded)
    if now is None or then is None:
        return f"{note}; no picture was recorded, so nobody can tell whether the content is the same"
    likeness = likeness_of(then, now)
    if not likeness.same:
        return None
    apart = f"mean difference {likeness.mean:.2f} of 255, large differences in {likeness.far:.1%} of the pixels"
    return f"{note}; the first picture shows the same content ({apart})"


def _stored_content(run: RunFolder, digest: Any) -> bytes | None:
    contents = (stored_picture(run.path, name) for name in run.pictures())
    return next((content for content in contents if content is not None and sha256_of(content) == digest), None)


def weights_apart(runs: Iterable[RunFolder]) -> Iterator[str]:
    """Yield a line for each run whose canary changed during the run or differs from the canary of an earlier run."""
    first: dict[str, tuple[str, Canary]] = {}
    for summary in _summaries(runs):
        for canary in summary.canaries:
            run, begun = first.setdefault(canary.model, (summary.run, canary))
            distance = Distance.between(begun.signs, canary.signs)
            if distance.verdict is Verdict.OTHER:
                yield f"{summary.run}: '{canary.model}' answered with other weights than in {run}: {distance}"
            elif canary.verdict is Verdict.OTHER:
                yield f"{summary.run}: '{canary.model}' changed its weights during the run: {canary.distance}"


def _summaries(runs: Iterable[RunFolder]) -> Iterator[RunSummary]:
    for run in runs:
        try:
            summary = run.summary()
        except RecordError:  # the run's own verdict reports it
            continue
        if summary is not None:
            yield summary
