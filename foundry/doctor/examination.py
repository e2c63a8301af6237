"""Checks the machine, and then each model of a sweep."""

import asyncio
import contextlib
import shutil
import sqlite3
from collections import defaultdict
from collections.abc import AsyncIterator, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from foundry import provenance
from foundry.canary import Distance, Verdict
from foundry.composing.preflight import check_sight, scenario_of
from foundry.doctor.hours import SizedPrompt, longest_prompt, remember_speed
from foundry.doctor.timing import Estimate, Use, measured_calls, on_cpu, request_of, uses_of, with_tries
from foundry.errors import BackendError, FoundryError, InputError, RequestError
from foundry.expansion import Sweep, settings_key
from foundry.models.answers.known_weights import KnownWeights, Signs
from foundry.models.answers.opening import existing_answers
from foundry.models.base import Loaded, Model, ModelInfo
from foundry.models.http.transport import Origin
from foundry.models.human.human_model import HumanModel
from foundry.models.wrappers.canaries import CanaryAsker, canary_of
from foundry.running.load import LoadResult
from foundry.storing.growing import same_weights
from foundry.storing.store import SweepFolder
from foundry.texts import one_line
from foundry.worlds.base import Scenario

CALL_BYTES = 1_100
"""Bytes that a call takes in the log of calls, the answer cache and the steps; measured on 2D runs."""
RUN_BYTES = 40_000
"""Bytes that a run takes besides its calls: configuration, summary, partly filled disk blocks."""
IMAGE_BYTES = 230_000
"""Bytes of a recorded first-person image at 512 x 384, PNG."""
FRAME_BYTES = 60_000
"""Bytes of a picture that `record.frames` stores."""
_TIGHT = 3
"""If less than this many times the needed disk space is free, the check gives a warning."""
UNLIMITED_REPLY = 1024
"""Maximum number of tokens of a reply that is assumed if the settings allow any number."""
COMMON_REPLY = 4
"""Usual replies are assumed to be this many times shorter than the longest reply that is allowed."""
_READ_LOG = "Find the cause in the log of the server, then repeat foundry doctor."
CUT_BEYOND = 8
"""Characters per token that no tokenizer reaches in English. If a server counts fewer tokens, it has cut the prompt."""


class Status(StrEnum):
    """The result of a check before a sweep."""

    OK = "ok"
    WARNING = "warning"  # the sweep would run, but its numbers may be misleading
    PROBLEM = "problem"  # the sweep would not run, or not to its end
    SKIPPED = "skipped"  # could not be checked


@dataclass(frozen=True)
class Finding:
    """The result of one check.

    Attributes:
        subject: what was checked, such as the name of a model.
        advice: what the user should do, or "".
    """

    check: str
    subject: str
    status: Status
    found: str
    advice: str = ""


def check_versions() -> Finding:
    """Report the versions of foundry and Python."""
    versions = {**provenance.versions(), "sqlite": sqlite3.sqlite_version}
    commit = provenance.git_commit()
    text = ", ".join(f"{name} {version}" for name, version in versions.items())
    return Finding("versions", "this machine", Status.OK, text + (f", commit {commit[:12]}" if commit else ""))


def check_drawing(scenarios: Iterable[Scenario]) -> Iterator[Finding]:
    """Report how this machine draws images, for worlds that show images."""
    seen = [scenario.name for scenario in scenarios if scenario.shows_images]
    if not seen:
        return
    # The world's own module selects the renderer; only worlds with images import VTK.
    from foundry.worlds.camera.eye.devices import check_rendering

    try:
        drawer = check_rendering()
    except InputError as error:
        yield Finding("drawing", ", ".join(seen), Status.PROBLEM, str(error), "Install the package that it names.")
    else:
        yield Finding("drawing", ", ".join(seen), Status.OK, f"by {drawer.name} ({drawer.why})")


def check_disk(folder: Path, *, runs: int, calls: int, images: int, frames: int) -> Finding:
    """Compare the free disk space with the size of the sweep."""
    need = runs * RUN_BYTES + calls * CALL_BYTES + images * IMAGE_BYTES + frames * FRAME_BYTES
    there = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    free = shutil.disk_usage(there).free
    text = f"about {megabytes(need)} needed, {megabytes(free)} free"
    if free < need:
        return Finding("disk", str(folder), Status.PROBLEM, text, "Choose another output.dir.")
    status = Status.WARNING if free < _TIGHT * need else Status.OK
    return Finding("disk", str(folder), status, text, "It may not be enough." if status is Status.WARNING else "")


def megabytes(count: int) -> str:
    """Return a number of bytes as a readable text, such as "12 MB"."""
    return f"{count / 1e9:,.1f} GB" if count >= 1e9 else f"{count / 1e6:,.0f} MB"


async def examine_model(
    use: Use, began: Mapping[str, Any] | None, cache: str, *, calls: bool
) -> AsyncIterator[Finding]:
    """Check one model. If `calls` is true, the model gets about twenty calls; their answers are not recorded."""
    name = use.model.name
    if isinstance(use.model, HumanModel):
        yield Finding("person", name, Status.SKIPPED, "a person is asked on the page of foundry play, not tested here")
        return
    try:
        info = await use.model.inspect()
    except Exception as error:  # noqa: BLE001 - the boundary: a backend of one's own may raise anything
        yield _refused_to_show(name, error)
        return
    yield _identity(info, began)
    if use.scenario.shows_images:
        yield _sight(info, use.scenario.name)
    if not calls:
        yield Finding("calls", name, Status.SKIPPED, "--no-calls: context, slots and seeds were not measured")
        return
    retried = with_tries(use)
    try:
        await retried.model.warm_up()
        loaded = Loaded()
        try:
            loaded = await use.model.loaded()
        except BackendError as error:
            yield Finding("memory", name, Status.SKIPPED, f"the server does not report how it runs the model: {error}")
        for finding in _memory(name, loaded):
            yield finding
        yield await _context(retried, info, loaded)
        measured = await measured_calls(retried)
        remember_speed(cache, name, measured.per_call_s)
        for finding in _under_load(name, measured, loaded):
            yield finding
        estimate = Estimate.of(use, measured, use.runs * use.scenario.count_calls())
        yield Finding("hours", name, Status.OK, estimate.line())
        async for finding in _canary(use.model, info, cache):
            yield finding
    except Exception as error:  # noqa: BLE001 - the boundary: a backend of one's own may raise anything
        yield _problem("calls", name, error)


def _refused_to_show(name: str, error: Exception) -> Finding:
    """Return the finding for a model that could not be inspected; its subject is the server if the server failed."""
    finding = _problem("model", name, error)
    address, cause = Origin.cut_off(finding.found)
    advice = finding.advice or _READ_LOG
    return replace(finding, check="server", subject=address, found=cause, advice=advice) if address else finding


def _problem(check: str, name: str, error: Exception) -> Finding:
    if not isinstance(error, FoundryError):
        raised = f"its class raises {type(error).__name__}: {one_line(error)}"
        return Finding(check, name, Status.PROBLEM, raised, "Correct the class of the model.")
    advice = error.advice or ("" if isinstance(error, InputError) else _READ_LOG)
    return Finding(check, name, Status.PROBLEM, one_line(error.problem), advice)


def _identity(info: ModelInfo, began: Mapping[str, Any] | None) -> Finding:
    now = {"digest": info.digest, "weights": info.weights}
    then = began and began["digest"]
    if began and then and (info.digest is None or not same_weights(began, now)):
        digests = f"its digest is {(info.digest or 'none')[:12]}, but the sweep in output.dir began with {then[:12]}"
        return Finding(
            "model", info.name, Status.PROBLEM, digests, "Restore the first weights, or use another output.dir."
        )
    digest = f"digest {info.digest[:12]}" if info.digest else "no digest: the server reports none"
    server = f", server {info.server_version}" if info.server_version else ""
    able = f", {', '.join(info.capabilities)}" if info.capabilities else ""
    if info.remote is not None:
        passed = f"{digest}{server}{able}; the server passes calls on to {info.remote}"
        advice = "The digest does not identify these weights: state in your report that the model is remote."
        return Finding("model", info.name, Status.WARNING, passed, advice)
    status = Status.OK if info.digest else Status.WARNING
    advice = "" if info.digest else "If its weights change, this cannot be detected: use a fixed version of the model."
    return Finding("model", info.name, status, digest + server + able, advice)


def _sight(info: ModelInfo, world: str) -> Finding:
    try:
        check_sight(info, world)
    except InputError as error:
        return Finding("vision", info.name, Status.PROBLEM, str(error), "A sweep would not start.")
    return Finding("vision", info.name, Status.OK, f"the model sees the images of world '{world}'")


def _memory(name: str, loaded: Loaded) -> Iterator[Finding]:
    if share := on_cpu(loaded):
        advice = "Calls are slow: use a smaller model, a smaller context or a stronger quantization."
        yield Finding("memory", name, Status.WARNING, share, advice)


async def _canary(model: Model, info: ModelInfo, cache: str) -> AsyncIterator[Finding]:
    """Compare the weights that answer now with those that gave the cached answers, by four short calls."""
    canary = canary_of(model)
    if canary is None or info.digest is None:
        return
    replies = await CanaryAsker(model).ask()
    if not replies:
        yield Finding("canary", model.name, Status.SKIPPED, "its server answers no canary calls")
        return
    answers = existing_answers(cache)
    signs: Signs = ()
    if answers is not None:
        with contextlib.closing(answers):
            signs = KnownWeights(answers, canary, info.digest).all().get(info.digest, ())
    if not signs:
        yield Finding(
            "canary", model.name, Status.OK, "it answers; the cache of answers contains no canary to compare it with"
        )
        return
    distance = max((Distance.between(signs, reply) for reply in replies), key=lambda distance_to: distance_to.order)
    status = Status.OK if distance.verdict is Verdict.SAME else Status.WARNING
    result = f"weights compared with those that gave the cached answers: {distance.verdict} ({distance})"
    yield Finding("canary", model.name, status, result)


async def _context(use: Use, info: ModelInfo, loaded: Loaded) -> Finding:
    """Let the server count the tokens of the longest possible prompt, and compare them with the context length."""
    limit = use.model.longest_reply or UNLIMITED_REPLY
    longest = longest_prompt(use.scenario, use.prompt, seed=use.seed, reply_tokens=limit)
    try:
        reply = await use.model.ask(request_of(use, longest.question))
    except RequestError as error:
        return await _refused(use, longest, limit, error)
    room = loaded.context_length or use.model.context_length or info.context_length
    return _fit(use.model.name, info, longest, reply.prompt_tokens, limit=limit, room=room)


async def _refused(use: Use, longest: SizedPrompt, limit: int, error: RequestError) -> Finding:
    """Report whether the prompt is too long only after the longest possible replies, or also after usual replies."""
    name, result = (
        use.model.name,
        f"the longest possible prompt ({longest.characters:,} characters) is refused: {error}",
    )
    common = longest_prompt(use.scenario, use.prompt, seed=use.seed, reply_tokens=limit // COMMON_REPLY)
    try:
        await use.model.ask(request_of(use, common.question))
    except RequestError:
        return Finding("context", name, Status.PROBLEM, result, "Raise the context, or shorten the history.")
    result = f"with shorter replies, the longest prompt ({common.characters:,} characters) fits; {result}"
    return Finding(
        "context", name, Status.WARNING, result, "A run with very long replies would fail: raise the context."
    )


def _fit(
    name: str, info: ModelInfo, longest: SizedPrompt, tokens: int | None, *, limit: int, room: int | None
) -> Finding:
    if tokens is None or room is None:
        return Finding("context", name, Status.SKIPPED, "the server reports no token counts or no context length")
    result = f"longest prompt: {tokens:,} tokens ({longest.characters:,} characters); context: {room:,} tokens"
    if tokens <= room // 2 + 2 < longest.characters // CUT_BEYOND:
        return Finding("context", name, Status.PROBLEM, f"{result}; the server cuts the prompt", "Raise the context.")
    if info.context_length is not None and info.context_length < room:
        advice = f"The model was trained with at most {info.context_length:,} tokens: lower the context to this number."
        return Finding("context", name, Status.WARNING, result, advice)
    if tokens + limit > room:
        advice = f"After the longest prompt, a reply of {limit:,} tokens would be cut: raise the context."
        return Finding("context", name, Status.WARNING, result, advice)
    return Finding("context", name, Status.OK, result)


def _slots(name: str, measured: LoadResult, loaded: Loaded) -> Finding:
    times = f"{measured.alone_s:.2g} s for a call alone, {measured.per_call_s:.2g} s per call if many are sent at once"
    if loaded.slots is None and measured.slots is None:
        reason = f"not measured: this machine was too slow to separate the server's time from its own delays; {times}"
        return Finding("parallel slots", name, Status.SKIPPED, reason, "Repeat when this machine is less busy.")
    slots = (
        f"{measured.slots} at once" if loaded.slots is None else (f"{loaded.slots} at once, according to the server")
    )
    queues = (loaded.slots or measured.slots) == 1
    advice = (
        "Calls wait for each other: raise OLLAMA_NUM_PARALLEL, or the similar setting of your server." if queues else ""
    )
    return Finding("parallel slots", name, Status.OK, f"{slots}; {times}", advice)


def _under_load(name: str, measured: LoadResult, loaded: Loaded) -> list[Finding]:
    share = f"under load, {measured.equal_under_load:.0%} of the answers stay the same"
    if not measured.alone_equal:
        result = f"a call that was sent twice got two different answers; {share}"
        seeds = Finding("seeds", name, Status.WARNING, result, "Seeds have no effect.")
    elif measured.equal_under_load < 1:
        advice_seeds = "Parallel calls change answers, so only cached and recorded answers make a study repeatable."
        seeds = Finding(
            "seeds", name, Status.WARNING, f"a call sent alone twice gets the same answer; {share}", advice_seeds
        )
    else:
        seeds = Finding("seeds", name, Status.OK, f"a call sent alone twice gets the same answer; {share}")
    return [_slots(name, measured, loaded), seeds, *_unsteady(name, measured)]


def _unsteady(name: str, measured: LoadResult) -> Iterator[Finding]:
    if measured.repeated:
        counted = f"{measured.repeated} of {measured.calls} calls were answered only after they were repeated"
        yield Finding("tries", name, Status.WARNING, counted, "A sweep repeats such calls too, which takes time.")
    if measured.undecided:
        counted = f"{measured.undecided} of {measured.calls} replies contain no text to read"
        yield Finding(
            "replies", name, Status.WARNING, counted, "A sweep records such a decision as empty, cut or failed."
        )


def examine(sweep: Sweep, settings: Mapping[str, Any], *, calls: bool = True) -> Iterator[Finding]:
    """Check a sweep, and yield each finding as soon as it is made."""
    yield check_versions()
    scenarios = {
        settings_key(condition.config["world"]): scenario_of(condition.config) for condition in sweep.conditions
    }
    yield from check_drawing(scenarios.values())
    yield _disk(sweep, settings, scenarios)
    unchecked: dict[Finding, list[str]] = defaultdict(list)
    with asyncio.Runner() as runner:
        began = _begun(settings)
        for use in uses_of(sweep, scenarios):
            findings = examine_model(use, began.get(use.model.name), settings["cache"]["path"], calls=calls)
            while (finding := runner.run(_next(findings))) is not None:
                if finding.check == "server":
                    unchecked[finding].append(use.model.name)
                else:
                    yield finding
            runner.run(use.model.close())
    for finding, names in unchecked.items():
        yield replace(finding, found=f"{finding.found} Not checked: {', '.join(names)}")


def _begun(settings: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    folder = settings["output"]["dir"]
    models = SweepFolder.open(Path(folder)).models if folder and Path(folder).exists() else []
    return {model["name"]: model for model in models}


async def _next(findings: AsyncIterator[Finding]) -> Finding | None:
    return await anext(findings, None)


def _disk(sweep: Sweep, settings: Mapping[str, Any], scenarios: Mapping[str, Scenario]) -> Finding:
    calls = images = frames = 0
    for run in sweep.runs:
        config = sweep.conditions[run.condition].config
        scenario = scenarios[settings_key(config["world"])]
        calls += scenario.count_calls()
        images += scenario.count_calls() if scenario.shows_images else 0
        every = int(config["record"]["frames"])
        frames += scenario.count_calls() // every if every else 0
    folder = Path(settings["output"]["dir"] or "outputs")
    return check_disk(folder, runs=len(sweep.runs), calls=calls, images=images, frames=frames)
