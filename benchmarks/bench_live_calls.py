"""Measures live calls per second and client CPU per call; baseline: bare HTTP clients that post the same bodies."""

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import aiohttp
import httpx
import msgspec
from measuring import (
    Cost,
    Server,
    Stopwatch,
    Swept,
    at_least,
    at_most,
    print_table,
    print_title,
    run_sweep,
    scratch,
    server,
)

from foundry.records import Call
from foundry.storing.store import SweepFolder

JSON = {"content-type": "application/json"}
Post = Callable[[bytes], Awaitable[None]]


@dataclass(frozen=True)
class Load:
    """Size of the measurement for every client; twenty agents make forty calls per step.

    Attributes:
        httpx_calls: number of calls of bare httpx; small if httpx is slow.
        aiohttp_calls: number of calls of bare aiohttp.
        repeats: number of measurements of foundry and of aiohttp.
    """

    latency_ms: int
    in_flight: int
    runs: int
    steps: int
    httpx_calls: int
    aiohttp_calls: int
    repeats: int


BUSY = Load(latency_ms=0, in_flight=1, runs=1, steps=20, httpx_calls=800, aiohttp_calls=800, repeats=2)
ONE = Load(latency_ms=50, in_flight=1, runs=1, steps=12, httpx_calls=60, aiohttp_calls=60, repeats=2)
SOME = Load(latency_ms=50, in_flight=32, runs=4, steps=10, httpx_calls=640, aiohttp_calls=1600, repeats=2)
MANY = Load(latency_ms=50, in_flight=256, runs=30, steps=4, httpx_calls=512, aiohttp_calls=4800, repeats=2)
WARM_UP = Load(latency_ms=0, in_flight=32, runs=1, steps=1, httpx_calls=0, aiohttp_calls=0, repeats=1)


@dataclass(frozen=True)
class Sample:
    """Result of one client.

    Attributes:
        in_flight_s: sum over the calls of the time in flight, seconds.
        server_cpu_s: CPU time of the server during the measurement, seconds.
    """

    calls: int
    cost: Cost
    in_flight_s: float
    server_cpu_s: float

    @property
    def per_s(self) -> float:
        """Calls per second."""
        return self.calls / self.cost.wall_s

    @property
    def cpu_ms(self) -> float:
        """Client CPU per call, milliseconds."""
        return 1000 * self.cost.cpu_s / self.calls


def foundry_sample(to: Server, load: Load, folder: Path) -> tuple[Sample, Swept]:
    """Run a whole sweep with an empty cache: prompts, keys, limit, retry, cache, log, records and parsing."""
    limit = load.in_flight
    before = to.cpu_s()
    swept = run_sweep(
        folder / "sweep",
        f"model.server.hosts='{to.url}'",
        f"model.server.in_flight={{min: {limit}, max: {limit}, initial: {limit}}}",
        f"world.steps={load.steps}",
        f"seed=0-{load.runs - 1}",
        "runner.workers=1",
        f"runner.open_runs={load.runs}",
    )
    used = to.cpu_s() - before
    if swept.cached:
        raise RuntimeError(f"{swept.cached} calls were answered by the cache.")
    in_flight_s = sum(call.timings["latency"] for call in logged_calls(swept.folder))
    return Sample(swept.calls, swept.running, in_flight_s, used), swept


def logged_calls(folder: SweepFolder) -> Iterable[Call]:
    """Yield all calls of a sweep."""
    return (call for run in folder.runs() for call in run.calls())


def bodies_of(swept: Swept) -> list[bytes]:
    """Return the bodies that foundry sent."""
    return [
        msgspec.json.encode(
            {
                **call.parameters,
                "messages": call.messages,
                "keep_alive": "30m",
                "options": {**call.parameters["options"], "seed": call.seed},
            }
        )
        for call in logged_calls(swept.folder)
    ]


async def httpx_sample(to: Server, bodies: Sequence[bytes], in_flight: int) -> Sample:
    """Post the bodies with one `httpx.AsyncClient`; it reads the replies and does not parse them."""
    limits = httpx.Limits(max_connections=in_flight, max_keepalive_connections=in_flight)
    async with httpx.AsyncClient(limits=limits, timeout=600, trust_env=False, headers=JSON) as client:

        async def post(body: bytes) -> None:
            (await client.post(f"{to.url}/api/chat", content=body)).raise_for_status()

        return await posted(to, post, bodies, in_flight)


async def aiohttp_sample(to: Server, bodies: Sequence[bytes], in_flight: int) -> Sample:
    """Post the bodies with one `aiohttp.ClientSession`; it reads the replies and does not parse them."""
    connector = aiohttp.TCPConnector(limit=in_flight)
    async with aiohttp.ClientSession(connector=connector, headers=JSON, raise_for_status=True) as session:

        async def post(body: bytes) -> None:
            async with session.post(f"{to.url}/api/chat", data=body) as response:
                await response.read()

        return await posted(to, post, bodies, in_flight)


async def posted(to: Server, post: Post, bodies: Sequence[bytes], in_flight: int) -> Sample:
    """Post the bodies, with a fixed number of calls in flight."""
    waiting = iter(bodies)
    latencies: list[float] = []

    async def slot() -> None:
        for body in waiting:
            started = time.perf_counter()
            await post(body)
            latencies.append(time.perf_counter() - started)

    server_cpu, watch = to.cpu_s(), Stopwatch()
    await asyncio.gather(*(slot() for _ in range(in_flight)))
    cost = watch.cost()
    return Sample(len(latencies), cost, sum(latencies), to.cpu_s() - server_cpu)


def fastest(samples: Sequence[Sample]) -> Sample:
    """Return the sample with the most calls per second."""
    return max(samples, key=lambda sample: sample.per_s)


def measure(load: Load) -> dict[str, Sample]:
    """Measure every client at one load; the bare clients post the bodies that foundry posted."""
    ours: list[Sample] = []
    with server(load.latency_ms / 1000) as to:
        for _ in range(load.repeats):
            with scratch() as folder:
                sample, swept = foundry_sample(to, load, folder)
                bodies = bodies_of(swept)
            ours.append(sample)
        few, many = bodies[: load.httpx_calls], bodies[: load.aiohttp_calls]
        theirs = [asyncio.run(aiohttp_sample(to, many, load.in_flight)) for _ in range(load.repeats)]
        slow = asyncio.run(httpx_sample(to, few, load.in_flight))
    return {"foundry, all in": fastest(ours), "bare httpx": slow, "bare aiohttp": fastest(theirs)}


def row(load: Load, client: str, sample: Sample, baseline: Sample) -> list[str]:
    return [
        f"{load.in_flight}",
        f"{load.latency_ms} ms",
        client,
        f"{sample.calls:,}",
        f"{sample.per_s:,.0f}",
        f"{sample.per_s / baseline.per_s:.2f}",
        f"{sample.cpu_ms:.2f}",
        f"{sample.cpu_ms / baseline.cpu_ms:.2f}",
        f"{sample.in_flight_s / sample.cost.wall_s:.1f}",
        f"{1000 * sample.server_cpu_s / sample.calls:.2f}",
        f"{100 * sample.server_cpu_s / sample.cost.wall_s:.0f} %",
    ]


def print_targets(ours: Mapping[Load, Sample]) -> None:
    rows = [
        [f"calls/s at {load.in_flight} in flight", f"{ours[load].per_s:,.0f}", *at_least(ours[load].per_s, target, "")]
        for load, target in ((SOME, 300), (MANY, 450))
    ]
    for load, sample in ours.items():
        name = f"client CPU per call at {load.in_flight} in flight, {load.latency_ms} ms"
        rows.append([name, f"{sample.cpu_ms:.2f} ms", *at_most(sample.cpu_ms, 1.5, "ms")])
    print_table(["foundry, all in", "measured", "target", ""], rows)


def main() -> None:
    print_title(
        "Live calls",
        "A local server in its own process answers after the given latency. The server shares the cores: its columns",
        "show its CPU time. The bare clients post the bodies that foundry posted and do nothing else. Ratios are",
        "to bare aiohttp. Best of two measurements, except for bare httpx (one). With 1 call in",
        "flight, every client sleeps between calls, so each call takes more CPU; the rows without latency show how",
        "much. foundry's CPU time contains the start of the sweep, about 50 ms.",
    )
    with server(0) as to, scratch() as folder:
        foundry_sample(to, WARM_UP, folder)  # what is imported on first use is start-up, not a call
    rows: list[list[str]] = []
    ours: dict[Load, Sample] = {}
    for load in (BUSY, ONE, SOME, MANY):
        samples = measure(load)
        ours[load] = samples["foundry, all in"]
        rows += [row(load, name, sample, samples["bare aiohttp"]) for name, sample in samples.items()]
    columns = ["in flight", "latency", "client", "calls", "calls/s", "ratio", "CPU ms/call", "ratio"]
    print_table([*columns, "really in flight", "server's CPU ms/call", "server busy"], rows)
    print_targets(ours)


if __name__ == "__main__":
    main()
