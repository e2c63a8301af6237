"""How made-up runs say that they ended."""

from foundry.records import Counts, RunSummary
from foundry.storing.store import RunFolder


def run_summary(folder: RunFolder, status: str, digests: dict[str, str]) -> RunSummary:
    """Return the `run.json` of a run with these record files."""
    config = folder.config()
    return RunSummary(
        run=folder.id,
        status=status,
        world=config["world"]["name"],
        model=config["model"]["name"],
        prompt=config["prompt"]["name"],
        seed=config["seed"],
        sampling_seed=config["sampling_seed"],
        foundry_version="0",
        python_version="3",
        packages={},
        git_commit=None,
        model_digest=None,
        server_version=None,
        counts=Counts(calls=12, cached=3, retries=2, prompt_tokens=4000, output_tokens=700, model_s=3.5),
        started="2026-01-01T00:00:00Z",
        ended="2026-01-01T00:00:01Z",
        duration_s=1.0,
        error=None if status == "complete" else "the server went away",
        error_type=None if status == "complete" else "TransientError",
        traceback=None,
        records_sha256=digests,
    )
