"""Writes the records of Every Eval Ever, one for each condition; this module needs the package `jsonschema`."""

import datetime
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema

from foundry.errors import InputError, RecordError
from foundry.exporting.writing import ExportedCondition, Files, Mean, Measured, Scores, sampling
from foundry.storing.store import write_atomically
from foundry.texts import counted

VERSION = "0.3.0"
LIBRARY = "foundry-worlds"
_ARGUMENTS = ("temperature", "top_p", "top_k", "max_tokens")
"""The sampling parameters for which the schema has a field."""
_UNKNOWN = {"deployment_type": "unknown", "model_availability": "unknown"}
LEFT_OUT = "left_out.json"
"""The exported file that lists measures without any result, with the reasons."""
_NOT_PORTABLE = re.compile(r'[<>:"\\|?*/\x00-\x1f]')


def record(condition: ExportedCondition, scores: Scores) -> dict[str, Any]:
    """Return the record of a condition, with results for declared measures that have a value and a better direction.

    The better direction of a measure says whether high or low values are better.
    """
    made = _epoch(condition.ended)
    model = model_id(condition)
    first = condition.runs[0].summary
    versions = {"python": first.python_version, **first.packages, "git_commit": first.git_commit}
    return {
        "schema_version": VERSION,
        "evaluation_id": f"{LIBRARY}/{condition.world}/{model}/{condition.identity(*condition.recorded)}/{made}",
        "evaluation_timestamp": _epoch(condition.started),
        "retrieved_timestamp": made,
        "source_metadata": {
            "source_name": f"sweep {condition.sweep}",
            "source_type": "evaluation_run",
            "source_organization_name": "not stated",
            "evaluator_relationship": "other",
            "additional_details": _texts({"left_out": sorted(left_out(scores)), "config": condition.config}),
        },
        "eval_library": {
            "name": LIBRARY,
            "version": first.foundry_version,
            "additional_details": _texts(versions),
        },
        "model_info": {
            "name": condition.model,
            "id": model,
            "additional_details": {**_UNKNOWN, **_texts(_backend(condition))},
        },
        "evaluation_results": _results(condition, scores),
    }


def left_out(scores: Scores) -> dict[str, str]:
    """Return, for each declared measure without a result, the reason."""
    reason = "no direction is better: it describes behaviour, but the schema requires a better direction"
    return {measure.name: reason for measure in scores.measures if not measure.better}


def model_id(condition: ExportedCondition) -> str:
    """Return the name of the model with its kind of server, as in "ollama/qwen3:4b"; a name with a slash stays."""
    if "/" in condition.model:
        return condition.model
    target = str(condition.config["model"]["_target_"]).split(".")
    return f"{target[2] if target[:2] == ['foundry', 'models'] else target[0]}/{condition.model}"


def _epoch(time: str) -> str:
    return str(int(datetime.datetime.fromisoformat(time).timestamp()))


def _texts(values: Mapping[str, Any]) -> dict[str, str]:
    """Return the values as texts, which the schema requires; values that are None are left out."""
    known = {name: value for name, value in values.items() if value is not None}
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in known.items()}


def _backend(condition: ExportedCondition) -> dict[str, Any]:
    first = condition.runs[0].summary
    return {
        "backend": condition.config["model"]["_target_"],
        "digest": first.model_digest,
        "server_version": first.server_version,
        "members": {member.model: member.digest for member in first.members} or None,
    }


def _results(condition: ExportedCondition, scores: Scores) -> list[dict[str, Any]]:
    means = scores.of_conditions.get(condition.number, {})
    shared = {
        "evaluation_name": condition.world,
        "evaluation_timestamp": _epoch(condition.started),
        "source_data": {
            "dataset_name": f"world {condition.world}",
            "source_type": "other",
            "additional_details": _texts(
                {
                    "prompt": condition.prompt,
                    "seeds": [run.summary.seed for run in condition.runs],
                    "swept": condition.factors,
                }
            ),
        },
        "generation_config": _generation(condition),
    }
    results = [
        measure for measure in scores.measures if measure.better and measure.name in means and means[measure.name].n
    ]
    return [
        {
            "evaluation_result_id": result.name,
            **shared,
            "metric_config": _metric(result),
            "score_details": _details(condition, means[result.name]),
        }
        for result in results
    ]


def _metric(measure: Measured) -> dict[str, Any]:
    return {
        "evaluation_description": measure.label,
        "metric_id": f"foundry.{measure.name}",
        "metric_name": measure.label,
        "lower_is_better": measure.better == "low",
        "score_type": "continuous",
        "min_score": measure.low if math.isfinite(measure.low) else "-Infinity",
        "max_score": measure.high if math.isfinite(measure.high) else "Infinity",
        "additional_details": _texts({"null": measure.null or None}),
    }


def _details(condition: ExportedCondition, mean: Mean) -> dict[str, Any]:
    uncertainty: dict[str, Any] = {"num_samples": mean.n}
    if math.isfinite(mean.sd):
        uncertainty["standard_deviation"] = mean.sd
    if math.isfinite(mean.low) and math.isfinite(mean.high):
        method = {"lower": mean.low, "upper": mean.high, "confidence_level": 0.95, "method": mean.interval}
        uncertainty["confidence_interval"] = method
    runs = {"runs_asked": condition.asked, "runs_complete": condition.complete}
    return {"score": mean.mean, "details": _texts(runs), "uncertainty": uncertainty}


def _generation(condition: ExportedCondition) -> dict[str, Any]:
    """Return the sampling parameters of the first call; they are equal in all calls of a model, except the seed."""
    call = next((call for run in condition.runs for call in run.calls()), None)
    if call is None:
        return {}
    known = sampling(call.parameters)
    arguments = {name: known[name] for name in _ARGUMENTS if name in known}
    return {"generation_args": arguments, "additional_details": _texts({"parameters": call.parameters})}


def write(conditions: Sequence[ExportedCondition], scores: Scores, folder: Path) -> Files:
    """Write an Every Eval Ever record for each condition with results, and a file that lists the left-out measures."""
    files = [_written(condition, scores, folder) for condition in conditions]
    if not any(files):
        raise InputError(
            "Every declared measure lacks a value or a better direction (high or low), so there is no record. Name "
            "other measures with --family, for example outcome.readable. A probe has none."
        )
    missing = left_out(scores)
    write_atomically(folder / LEFT_OUT, _json(missing))
    notes = _notes(conditions, files, missing, folder)
    return Files(tuple(file for file in files if file is not None), tuple(notes))


def _written(condition: ExportedCondition, scores: Scores, folder: Path) -> Path | None:
    content = record(condition, scores)
    if not content["evaluation_results"]:
        return None
    check(content)
    developer, _, model = model_id(condition).partition("/")
    places = [_NOT_PORTABLE.sub("_", part) for part in (LIBRARY, developer, model)]
    path = folder.joinpath("data", *places, f"{condition.identity(*condition.recorded)}.json")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, _json(content))
    return path


def check(record: dict[str, Any]) -> None:
    """Raise an error if a record does not fit the published schema."""
    error = jsonschema.exceptions.best_match(jsonschema.Draft7Validator(_schema()).iter_errors(record))
    if error is not None:
        raise RecordError(f"A record does not fit the schema of Every Eval Ever at {error.json_path}: {error.message}")


@cache
def _schema() -> dict[str, Any]:
    content: dict[str, Any] = json.loads((Path(__file__).parent / "eval.schema.json").read_text(encoding="utf-8"))
    return content


def _json(content: Any) -> bytes:
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False).encode() + b"\n"


def _notes(
    conditions: Sequence[ExportedCondition], files: Sequence[Path | None], missing: dict[str, str], folder: Path
) -> Iterator[str]:
    for condition, file in zip(conditions, files, strict=True):
        if file is None:
            yield f"{condition.label}: no record, because every declared measure lacks a value or a better direction"
    if missing:
        measures = counted(len(missing), "declared measure")
        yield f"left out: {measures}, because neither high nor low values are better; see {folder / LEFT_OUT}"
