"""Measures the calls that a probe needs for intervals of the same width: `python benchmarks/bench_probe.py`.

The script compares the share of each action between two scripted policies, in free runs and in moments of these runs.
Then it asks a random model on a llama.cpp server, which says `go` or `stay`, in moments of a bar: once with
log-probabilities, and by repeats. The width of an interval over seeds is proportional to sd / sqrt(seeds). So for a
given width, the number of calls is proportional to sd^2 times the calls per seed. FOUNDRY_LLAMA_PYTHON names a Python
with the packages xllamacpp, gguf and tokenizers; without it, the second part is left out.
"""

import itertools
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import msgspec
import numpy as np
import pandas as pd
from bench_llama import PYTHON, URL, made, serving
from measuring import Stopwatch, print_table, print_title, scratch

from foundry.storing.store import RunFolder, SweepFolder

SEEDS = 10
WORLDS: Mapping[str, tuple[Sequence[str], Sequence[str]]] = {
    "cafe_library": (("random", "herd", "avoid"), ("world=cafe_library", "world.steps=50")),
    "survival": (("random", "forager", "sharer"), ("world=survival", "world.steps=40")),
}
"""The policies that are compared in each world, and the settings of the world."""
MOMENTS, REPEATS = 12, (1, 10)
"""Number of moments per seed, and of repeats per moment."""
QUIET = ("analyze=false", "determinism=0", "view=null")
ASKED_SEEDS, ASKED_REPEATS = 12, 20
"""Runs with the moments in which the server is asked, and the number of repeats per moment."""
OPENLY = ("model.options.temperature=1", "model.options.top_p=1", "+model.extra.top_k=0", "+model.extra.min_p=0")
MOMENT = ["seed", "run", "step", "agent", "kind", "again"]


def foundry(*arguments: str, cwd: Path) -> None:
    """Run a command that succeeds; `model=openai/...` is the llama.cpp server."""
    served = {"OPENAI_BASE_URL": f"{URL}/v1", "OPENAI_API_KEY": "none", "FOUNDRY_CANARY": "false"}
    program = [sys.executable, "-m", "foundry", *arguments]
    subprocess.run(program, cwd=cwd, env={**os.environ, **served}, check=True, stdout=subprocess.DEVNULL)


def shares(path: Path) -> dict[str, dict[int, dict[str, float]]]:
    """Return the share of each action among the readable actions, by model and seed."""
    counts: dict[str, dict[int, Counter[str]]] = {}
    for run in SweepFolder.open(path).runs():
        mine = counts.setdefault(run.config()["model"]["name"], {}).setdefault(run.run.seed, Counter())
        mine.update(actions(run))
    return {
        model: {
            seed: {choice: counts[choice] / counts.total() for choice in counts} for seed, counts in by_seed.items()
        }
        for model, by_seed in counts.items()
    }


def actions(run: RunFolder) -> Iterable[str]:
    """Return the action in each answer to a question about actions; for a move, its direction."""
    for line in msgspec.json.Decoder().decode_lines(run.steps_bytes()):
        if line.get("kind", "action") == "action" and isinstance(line["action"], str):
            yield line.get("direction") or line["action"]


def spread_of_pair(
    shares_by_model: Mapping[str, Mapping[int, Mapping[str, float]]], pair: Sequence[str], action: str
) -> float:
    """Return the standard deviation over seeds of the paired difference of two models."""
    first, second = (shares_by_model[model] for model in pair)
    return float(np.std([first[seed].get(action, 0) - second[seed].get(action, 0) for seed in first], ddof=1))


def calls_of_seed(path: Path) -> float:
    """Return the number of questions to a model per seed."""
    runs = SweepFolder.open(path).runs()
    asked = sum(sum(1 for _ in run.calls()) for run in runs)
    return asked / len({(run.config()["model"]["name"], run.run.seed) for run in runs})


def compare(name: str, policies: Sequence[str], overrides: Sequence[str], folder: Path) -> list[list[str]]:
    """Return a row for each number of repeats: the calls of free runs divided by the calls of a probe."""
    named = [f"scripted/{policy}" for policy in policies]
    models = f"model={','.join(named)}"
    foundry("-m", models, f"seed=0-{SEEDS - 1}", *overrides, *QUIET, "output.dir=free", cwd=folder)
    free, rows = shares(folder / "free"), []
    for repeats in REPEATS:
        asked = (f"moments={MOMENTS * SEEDS}", f"repeats={repeats}", f"output.dir=probe{repeats}")
        foundry("probe", "free", "-m", models, *asked, *QUIET, cwd=folder)
        probe = shares(folder / f"probe{repeats}")
        calls = [calls_of_seed(folder / name) for name in ("free", f"probe{repeats}")]
        ratios = []
        for pair in itertools.combinations(named, 2):
            for action in sorted(
                {choice for model in pair for shares_of_seed in free[model].values() for choice in shares_of_seed}
            ):
                sds = [spread_of_pair(shares_by_model, pair, action) for shares_by_model in (free, probe)]
                if min(sds) > 0:
                    ratios.append((sds[0] ** 2 * calls[0]) / (sds[1] ** 2 * calls[1]))
        low, middle, high = np.quantile(ratios, (0, 0.5, 1))
        rows.append([name, str(repeats), f"{calls[0]:,.0f}", f"{calls[1]:,.0f}", str(len(ratios)),
                     f"{low:.1f}", f"{middle:.1f}", f"{high:.1f}"])  # fmt: skip
    return rows


def probed(folder: Path, name: str, *settings: str) -> pd.DataFrame:
    """Return the share of `go` and the number of calls in each moment of a probe with these settings."""
    sizes = (f"moments={ASKED_SEEDS * MOMENTS}", "window=0", f"repeats={ASKED_REPEATS}")
    asked = (*sizes, *OPENLY, "model.options.max_tokens=4")
    foundry("probe", "pilot", "model=openai/tiny", *asked, *settings, *QUIET, f"output.dir={name}", cwd=folder)
    foundry("analyze", name, cwd=folder)
    moments = pd.read_csv(folder / name / "analysis" / "moments.csv", keep_default_na=False)
    calls = moments.groupby(MOMENT)["count"].sum()
    go = moments[moments["choice"] == "go"].set_index(MOMENT)["share"]
    unread = moments[moments["choice"] == "unreadable"]["count"].sum()
    sys.stdout.write(f"{name}: by {', '.join(sorted(set(moments['by'])))}; {unread} of {calls.sum()} unreadable\n")
    return pd.DataFrame({"go": go.reindex(calls.index, fill_value=0.0), "calls": calls})


def spread(frame: pd.DataFrame) -> float:
    """Return the standard deviation over seeds; the value of a seed is the mean share over its moments."""
    return float(frame["go"].groupby("seed").mean().std(ddof=1))


def row(name: str, sampled: pd.DataFrame, by_probability: pd.DataFrame) -> list[str]:
    """Return the calls, the half-width of the interval over seeds, and the calls for the width of probabilities."""
    sd, calls = spread(sampled), int(sampled["calls"].sum())
    ratio = sd**2 * calls / (spread(by_probability) ** 2 * by_probability["calls"].sum())
    return [name, f"{calls:,}", f"{sampled['go'].mean():.3f}", f"{2.2 * sd / np.sqrt(ASKED_SEEDS):.4f}", f"{ratio:.1f}"]


def followed(by_probability: pd.DataFrame, folder: Path) -> float:
    """Return the number of samples that the expected share and the sampling seed predict.

    llama.cpp seeds a Mersenne twister with the seed of the call, draws a number below 1 and goes through the tokens in
    the order of the vocabulary, in which `go` comes before `stay`.
    """
    rows = []
    share = by_probability["go"].droplevel(["run", "kind", "again"])
    for run in SweepFolder.open(folder).runs():
        for call in run.calls():
            drawn = int.from_bytes(np.random.RandomState(call.seed).bytes(8), "little") / 2**64
            rows.append((drawn < share[run.run.seed, call.step, call.agent]) == (call.text == "go"))
    return float(np.mean(rows))


def print_beside_free_runs() -> None:
    """Print the calls of free runs divided by the calls of a probe, for scripted policies."""
    print_title(
        "Calls for an interval of the same width: free runs and a probe",
        f"Pairs of scripted policies, {SEEDS} seeds, {MOMENTS} moments a seed; shares of each action.",
    )
    rows = []
    for name, (policies, overrides) in WORLDS.items():
        with scratch() as folder:
            rows += compare(name, policies, overrides, folder)
    heads = ["world", "repeats", "calls a seed, free", "probe", "differences", "fewer by: least", "median", "most"]
    print_table(heads, rows)


def print_probabilities() -> None:
    """Compare the probabilities of a server with samples, and print how well the probabilities predict the samples."""
    print_title("Probes by probabilities on a llama.cpp server", f"{ASKED_SEEDS} seeds, {MOMENTS} moments each.")
    with scratch() as folder:
        pilot = ("world=bar", "world.agents=4", "world.steps=6", "model=scripted/random", f"seed=0-{ASKED_SEEDS - 1}")
        foundry("-m", *pilot, *QUIET, "output.dir=pilot", cwd=folder)
        with serving(made(folder, ("--seed", "1", "--words", "go,stay"))):
            by_probability = probed(folder, "told", "model.logprobs=5")
            sampled = probed(folder, "sampled")
            once = probed(folder, "once", "repeats=1")
        exact = followed(by_probability, folder / "sampled")
    rows = [
        row("probabilities", by_probability, by_probability),
        row("one sample a moment", once, by_probability),
        row(f"{ASKED_REPEATS} samples a moment", sampled, by_probability),
    ]
    print_table(["a moment is asked by", "calls", "share of go", "half interval", "calls for one width"], rows)
    variance = by_probability["go"] * (1 - by_probability["go"]) / ASKED_REPEATS
    z = (sampled["go"] - by_probability["go"]) / np.sqrt(variance)
    mean = (sampled["go"].mean() - by_probability["go"].mean()) / (np.sqrt(variance.sum()) / len(by_probability))
    print_table(
        ["samples against expected shares", ""],
        [
            ["moments within the 95 % interval of their samples", f"{(z.abs() <= 1.96).mean():.3f}"],
            ["mean of z^2 over moments (1 by chance)", f"{(z**2).mean():.2f}"],
            ["z of the mean share", f"{mean:.2f}"],
            ["samples that follow from the expected share and the seed", f"{exact:.3f}"],
            [
                "expected share of a moment, least and greatest",
                f"{by_probability['go'].min():.3f} to {by_probability['go'].max():.3f}",
            ],
        ],
    )


if __name__ == "__main__":
    watch = Stopwatch()
    print_beside_free_runs()
    if PYTHON in os.environ:
        print_probabilities()
    else:
        sys.stdout.write(f"Probabilities: not measured, {PYTHON} names no Python.\n")
    print(f"{watch.cost().wall_s:.0f} s in all", file=sys.stderr)
