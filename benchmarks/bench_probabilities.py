"""Measures what log-probabilities save in a probe of a llama.cpp server: `python benchmarks/bench_probabilities.py`.

A random model that says `go` or `stay` is asked in moments of a bar: once with probabilities, and by repeats. An
interval over seeds is as wide as sd / sqrt(seeds), so that for one width the calls are as sd^2 times the calls of a
seed. FOUNDRY_LLAMA_PYTHON names a Python with the packages xllamacpp, gguf and tokenizers; without it nothing is
measured.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from bench_llama import PYTHON, URL, made, serving
from measuring import print_table, print_title, scratch

from foundry.storing.store import SweepFolder

SEEDS, MOMENTS, REPEATS = 12, 12, 20
"""Runs, moments of each, and repeats of each moment."""
OPENLY = ("model.options.temperature=1", "model.options.top_p=1", "+model.extra.top_k=0", "+model.extra.min_p=0")
QUIET = ("analyze=false", "determinism=0", "view=null")
MOMENT = ["seed", "run", "step", "agent", "kind", "again"]


def foundry(*arguments: str, cwd: Path) -> None:
    """Run a command that succeeds."""
    served = {"OPENAI_BASE_URL": f"{URL}/v1", "OPENAI_API_KEY": "none", "FOUNDRY_CANARY": "false"}
    program = [sys.executable, "-m", "foundry", *arguments]
    subprocess.run(program, cwd=cwd, env={**os.environ, **served}, check=True, stdout=subprocess.DEVNULL)


def probed(folder: Path, name: str, *settings: str) -> pd.DataFrame:
    """Return the share of `go` and the calls by moment, in a probe with these settings."""
    asked = (f"moments={SEEDS * MOMENTS}", "window=0", f"repeats={REPEATS}", *OPENLY, "model.options.max_tokens=4")
    foundry("probe", "pilot", "model=openai/tiny", *asked, *settings, *QUIET, f"output.dir={name}", cwd=folder)
    foundry("analyze", name, cwd=folder)
    moments = pd.read_csv(folder / name / "analysis" / "moments.csv", keep_default_na=False)
    calls = moments.groupby(MOMENT)["count"].sum()
    go = moments[moments["choice"] == "go"].set_index(MOMENT)["share"]
    unread = moments[moments["choice"] == "unreadable"]["count"].sum()
    sys.stdout.write(f"{name}: by {', '.join(sorted(set(moments['by'])))}; {unread} of {calls.sum()} unreadable\n")
    return pd.DataFrame({"go": go.reindex(calls.index, fill_value=0.0), "calls": calls})


def spread(found: pd.DataFrame) -> float:
    """Return the standard deviation over seeds of the mean share of the moments of a seed."""
    return float(found["go"].groupby("seed").mean().std(ddof=1))


def row(name: str, found: pd.DataFrame, told: pd.DataFrame) -> list[str]:
    """Return the calls, the half interval over seeds, and how many calls give the interval of probabilities."""
    sd, calls = spread(found), int(found["calls"].sum())
    ratio = sd**2 * calls / (spread(told) ** 2 * told["calls"].sum())
    return [name, f"{calls:,}", f"{found['go'].mean():.3f}", f"{2.2 * sd / np.sqrt(SEEDS):.4f}", f"{ratio:.1f}"]


def followed(told: pd.DataFrame, folder: Path) -> float:
    """Return in how many samples the server decided as the expected share and the sampling seed say.

    llama.cpp seeds a Mersenne twister with the seed of the call, draws a number below 1 and goes through the tokens in
    the order of the vocabulary, in which `go` comes before `stay`.
    """
    rows = []
    share = told["go"].droplevel(["run", "kind", "again"])
    for run in SweepFolder.open(folder).runs():
        for call in run.calls():
            drawn = int.from_bytes(np.random.RandomState(call.seed).bytes(8), "little") / 2**64
            rows.append((drawn < share[run.run.seed, call.step, call.agent]) == (call.text == "go"))
    return float(np.mean(rows))


def main() -> None:
    """Print both tables."""
    if PYTHON not in os.environ:
        sys.stdout.write(f"Probabilities: not measured, {PYTHON} names no Python.\n")
        return
    print_title("Probes by probabilities on a llama.cpp server", f"{SEEDS} seeds, {MOMENTS} moments each.")
    with scratch() as folder:
        pilot = ("world=bar", "world.agents=4", "world.steps=6", "model=scripted/random", f"seed=0-{SEEDS - 1}")
        foundry("-m", *pilot, *QUIET, "output.dir=pilot", cwd=folder)
        with serving(made(folder, ("--seed", "1", "--words", "go,stay"))):
            told = probed(folder, "told", "model.logprobs=5")
            sampled = probed(folder, "sampled")
            once = probed(folder, "once", "repeats=1")
        exact = followed(told, folder / "sampled")
    rows = [
        row("probabilities", told, told),
        row("one sample a moment", once, told),
        row(f"{REPEATS} samples a moment", sampled, told),
    ]
    print_table(["a moment is asked by", "calls", "share of go", "half interval", "calls for one width"], rows)
    variance = told["go"] * (1 - told["go"]) / REPEATS
    z = (sampled["go"] - told["go"]) / np.sqrt(variance)
    mean = (sampled["go"].mean() - told["go"].mean()) / (np.sqrt(variance.sum()) / len(told))
    print_table(
        ["samples against expected shares", ""],
        [
            ["moments within the 95 % interval of their samples", f"{(z.abs() <= 1.96).mean():.3f}"],
            ["mean of z^2 over moments (1 by chance)", f"{(z**2).mean():.2f}"],
            ["z of the mean share", f"{mean:.2f}"],
            ["samples that follow from the expected share and the seed", f"{exact:.3f}"],
            ["expected share of a moment, least and greatest", f"{told['go'].min():.3f} to {told['go'].max():.3f}"],
        ],
    )


if __name__ == "__main__":
    main()
