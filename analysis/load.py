"""Reads recorded runs, as tidy tables for people or as arrays for signatures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import msgspec
import pandas as pd
import pyarrow as pa  # type: ignore[import-untyped]

from analysis.arrow import arrow_table
from analysis.findings.finding_records import FILE as FINDINGS_FILE
from analysis.findings.finding_records import findings_frame
from analysis.form import FormAnalysis, NoDecisionsError, Records, form_of
from analysis.lines import COMPLETE, NOT_STARTED, UNFINISHED, read_agents, read_further
from analysis.measuring.events import FILE as EVENTS_FILE
from foundry.errors import InputError, RecordError
from foundry.records import NOT_JSON, Call, CameraEpisode, Message, RunSummary
from foundry.storing.store import RunFolder, SweepFolder

_TABLES = ("steps", "messages", "agents")
"""The record files that become tables with the same names."""

_IDENTITY = ("run", "world", "model", "prompt", "seed")
"""The columns that name the run of a row, in every table."""

_CALL_COLUMNS = (
    "step", "agent", "kind", "asked_model", "sampling_seed", "prompt_text", "reply", "thinking", "ending",
    "prompt_tokens", "output_tokens", "latency_s", "failed_tries", "cached",
)  # fmt: skip

_PROBE = "probe"
"""The form of the runs of a probe."""

Folders: TypeAlias = Path | str | Sequence[Path | str]
"""The folder of a sweep, or the folders of several sweeps."""


def is_probe(folder: SweepFolder) -> bool:
    """Return whether a sweep is a probe."""
    return {run.declared.form for run in folder.runs()} == {_PROBE}


@dataclass(frozen=True)
class Loaded:
    """A sweep as tidy tables.

    All tables begin with the columns `run`, `world`, `model`, `prompt` and `seed`, for `groupby`.
    If a record has a key with one of these names, its column is `record.<key>`.

    Attributes:
        path: the sweep's folder.
        runs: one row per run with run, world, model, prompt, seed, status, and the further swept settings.
        steps: one row per run, step and agent, or per decision, with the keys of the form's records, such as
            `foundry.records.GridStep`. The pose and command of `CameraStep` become several columns, as in
            `analysis.camera.camera_records.flat`. Keys of other forms are missing values.
        agents: one row per run and agent with a persona; its attributes are the columns `persona.<attribute>`.
        messages: one row per run and delivery; the keys of `foundry.records.Message`.
        streams: one row per run and line of every further record file that a world declares, by its name. For example,
            3D worlds have `episode` with the keys of `foundry.records.CameraEpisode`.
        fixtures: by kind, a table with one row per run and thing in its world: `fires` and `places` of 2D worlds, with
            their cells. A spreading fire begins at this cell. Runs without records have no rows.
    """

    path: Path
    runs: pd.DataFrame
    steps: pd.DataFrame
    agents: pd.DataFrame
    messages: pd.DataFrame
    streams: Mapping[str, pd.DataFrame]
    fixtures: Mapping[str, pd.DataFrame]

    def to_arrow(self) -> dict[str, pa.Table]:
        """Return all tables except `calls` as `pyarrow.Table`, by name, including each stream and each fixture."""
        names = ("runs", "steps", "agents", "messages")
        frames = {**{name: getattr(self, name) for name in names}, **self.fixtures, **self.streams}
        return {name: arrow_table(frame) for name, frame in frames.items()}

    @property
    def episodes(self) -> pd.DataFrame:
        """One row per run of a 3D world: the stream `episode`."""
        return self.streams.get(
            CameraEpisode.stream, pd.DataFrame(columns=[*_IDENTITY, *CameraEpisode.__struct_fields__])
        )

    @cached_property
    def calls(self) -> pd.DataFrame:
        """One row per run and model call, read on first use, since prompts are long.

        Columns: `step`, `agent`, `kind`, `asked_model` (differs from `model` in mixed populations), `sampling_seed`,
        `prompt_text`, `reply`, `thinking`, `ending`, `prompt_tokens`, `output_tokens`, `latency_s` (for a cached
        answer, its original time), `failed_tries`, `cached`. Unknown values are missing values.

        Raises:
            RecordError: a log of calls is damaged.
        """
        frames = [
            _frame(folder, [_call_row(call) for call in folder.calls()], _CALL_COLUMNS)
            for folder in SweepFolder.open(self.path).runs()
        ]
        return _joined(frames).astype(dict.fromkeys(("prompt_tokens", "output_tokens", "latency_s"), float))

    @cached_property
    def findings(self) -> pd.DataFrame:
        """One row per finding of the last `foundry analyze`; columns as in `FindingRecord`.

        Its `moments` are lists of mappings with the keys of `analysis.findings.moments.Moment`.

        Raises:
            InputError: the sweep was not analysed.
            RecordError: the file is damaged.
        """
        path = self._analysed(FINDINGS_FILE)
        try:
            return findings_frame(path.read_bytes())
        except NOT_JSON as error:
            raise RecordError(f"'{path}' cannot be read: {error}. Run foundry analyze {self.path} again.") from error

    @cached_property
    def events(self) -> pd.DataFrame:
        """One row per event of the last `foundry analyze`: run, step, agent (missing without one), event, text.

        Raises:
            InputError: the sweep was not analysed.
        """
        return pd.read_parquet(self._analysed(EVENTS_FILE)).astype({"agent": "Int64"})

    def _analysed(self, name: str) -> Path:
        """Return the path of a file of the analysis, or raise an InputError if it does not exist."""
        path = SweepFolder.open(self.path).analysis_dir / name
        if not path.is_file():
            raise InputError(f"'{path}' does not exist. Run foundry analyze {self.path} first.")
        return path


def runs_by_id(sweeps: Sequence[SweepFolder]) -> Mapping[str, RunFolder]:
    """Return the runs of sweeps by id; if a run is in several sweeps, the first copy is used."""
    return {run.id: run for sweep in reversed(sweeps) for run in sweep.runs()}


def folders_of(dirs: Folders) -> list[Path]:
    """Return a list of folders, even if `dirs` is a single one."""
    return [Path(path) for path in ([dirs] if isinstance(dirs, str | Path) else dirs)]


def load(path: Path | str) -> Loaded:
    """Load a sweep, with the lines that unfinished runs have so far.

    Raises:
        InputError: the folder holds no sweep, or the code of its form cannot be used.
        RecordError: a recorded file is damaged.
    """
    folders = SweepFolder.open(Path(path)).runs()
    read = [(folder, read_records(folder, folder.summary())) for folder in folders]
    steps = [(folder, records.rows()) for folder, records in read]
    return Loaded(
        path=Path(path),
        runs=pd.DataFrame([{**identity(folder), **further_factors(folder)} for folder in folders]),
        steps=_joined([_frame(folder, rows, _keys(folder, "steps")) for folder, rows in steps]),
        agents=_joined([_personas(folder) for folder in folders]),
        messages=_joined(
            [_frame(folder, _rows(records.messages), Message.__struct_fields__) for folder, records in read]
        ),
        streams=_further_streams(folders),
        fixtures=_fixtures([folder for folder, rows in steps if rows]),
    )


def _fixtures(folders: Sequence[RunFolder]) -> dict[str, pd.DataFrame]:
    frames: dict[str, list[pd.DataFrame]] = {}
    for folder in folders:
        for kind, frame in form_of(folder.declared.form).fixtures(folder).items():
            frames.setdefault(kind, []).append(_of_run(folder, frame.to_dict("list")))
    return {kind: _joined(joined_frames) for kind, joined_frames in frames.items()}


def _call_row(call: Call) -> dict[str, Any]:
    texts = [message["content"] for message in call.messages]
    values = (
        call.step,
        call.agent,
        call.kind,
        call.model,
        call.seed,
        "\n\n".join(texts),
        call.text,
        call.thinking,
        call.ending,
        call.prompt_tokens,
        call.output_tokens,
        call.timings.get("latency"),
        len(call.attempts),
        call.cached,
    )
    return dict(zip(_CALL_COLUMNS, values, strict=True))


def _keys(folder: RunFolder, stream: str) -> tuple[str, ...]:
    return tuple(folder.declared.streams.get(stream, ()))


def _further_streams(folders: Sequence[RunFolder]) -> dict[str, pd.DataFrame]:
    frames: dict[str, list[pd.DataFrame]] = {}
    for folder in folders:
        for name in folder.streams:
            if name in folder.declared.streams and name not in _TABLES:
                lines = read_further(folder, name, folder.summary())
                frames.setdefault(name, []).append(_frame(folder, lines, _keys(folder, name)))
    return {name: _joined(frames) for name, frames in frames.items()}


def _personas(folder: RunFolder) -> pd.DataFrame:
    lines = read_agents(folder, folder.summary())
    personas = ({f"persona.{name}": value for name, value in line.persona.items()} for line in lines)
    rows = [{"agent": line.agent, **persona} for line, persona in zip(lines, personas, strict=True)]
    return _of_run(folder, pd.DataFrame(rows, columns=None if rows else ["agent"]).to_dict("list"))


def identity(folder: RunFolder) -> dict[str, Any]:
    """Return the columns that identify a run, and its status."""
    return {**_which(folder), "status": status(folder, folder.summary())}


def _which(folder: RunFolder) -> dict[str, Any]:
    config = folder.config()
    values = (folder.id, *(config[part]["name"] for part in ("world", "model", "prompt")), config["seed"])
    return dict(zip(_IDENTITY, values, strict=True))


def status(folder: RunFolder, summary: RunSummary | None) -> str:
    """Return the status of a run."""
    if summary is not None:
        return summary.status
    return UNFINISHED if folder.path.exists() else NOT_STARTED


def further_factors(folder: RunFolder) -> dict[str, Any]:
    """Return the swept settings of a run, without world, model, prompt and seed."""
    return {key: value for key, value in folder.factors.items() if key not in ("world", "model", "prompt", "seed")}


def read_records(folder: RunFolder, summary: RunSummary | None) -> Records:
    """Read the lines of a run, without the incomplete last line of an unfinished run.

    Raises:
        InputError: the code of its form cannot be used, or lines do not fit the form.
        RecordError: a file is damaged, or was changed after the run.
    """
    return form_of(folder.declared.form).read(folder, summary)


@dataclass(frozen=True)
class Measurable:
    """A complete run, as lines and as arrays."""

    form: FormAnalysis
    records: Records
    run: Any


def measurable(folder: RunFolder, summary: RunSummary | None) -> Measurable | None:
    """Return a run; None if it is incomplete or has no decisions, like some runs of foundry 0.1 in unknown worlds.

    Raises:
        InputError: the code of its form cannot be used, or lines do not fit the form.
        RecordError: a file is damaged.
    """
    if status(folder, summary) != COMPLETE:
        return None
    form = form_of(folder.declared.form)
    records = form.read(folder, summary)
    try:
        return Measurable(form, records, records.arrays(folder))
    except NoDecisionsError:
        return None


def read_run(folder: RunFolder, records: Records) -> Any:
    """Return a complete run as arrays, in the class of its form.

    Raises:
        InputError: the settings of its world do not fit its form.
        RecordError: the lines do not make a run of its form.
    """
    return records.arrays(folder)


def _rows(lines: Sequence[msgspec.Struct]) -> list[dict[str, Any]]:
    return [msgspec.structs.asdict(line) for line in lines]


def _frame(folder: RunFolder, rows: Sequence[dict[str, Any]], keys: Sequence[str]) -> pd.DataFrame:
    return _of_run(folder, _columns(rows, keys))


def _columns(rows: Sequence[dict[str, Any]], keys: Sequence[str]) -> dict[str, list[Any]]:
    return {name: [row[name] for row in rows] for name in (list(rows[0]) if rows else keys)}


def _of_run(folder: RunFolder, columns: Mapping[Any, list[Any]]) -> pd.DataFrame:
    length = len(next(iter(columns.values()), ()))
    own = {f"record.{name}" if name in _IDENTITY else name: values for name, values in columns.items()}
    return pd.DataFrame({**{name: [value] * length for name, value in _which(folder).items()}, **own})


def _joined(frames: Sequence[pd.DataFrame]) -> pd.DataFrame:
    full = [frame for frame in frames if len(frame)]
    return pd.concat(full, ignore_index=True) if full else frames[0]
