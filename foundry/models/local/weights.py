"""Finds the files of a local model, and computes a hash of the files that affect its answers."""

import hashlib
import json
import os
import re
from pathlib import Path

from foundry import paths
from foundry.errors import InputError

DECIDING = frozenset({".safetensors", ".bin", ".json", ".jinja", ".model", ".txt", ".tiktoken"})
"""Suffixes of the files that affect answers: weights, configuration, tokenizer and template."""
WEIGHTS = frozenset({".safetensors", ".bin"})
SHA256 = re.compile(r"[0-9a-f]{64}")


def find_folder(weights: str, revision: str | None) -> Path:
    """Return the folder with a model's files; `weights` is this folder, or the id of a model downloaded before.

    foundry itself downloads nothing.
    """
    folder = Path(weights).expanduser()
    if not folder.is_dir():
        folder = _downloaded(weights, revision)
    if not (folder / "config.json").is_file() or not any(file.suffix in WEIGHTS for file in folder.iterdir()):
        raise InputError(f"'{folder}' is not a model: it contains no config.json, or no weights (.safetensors).")
    return folder


def _downloaded(weights: str, revision: str | None) -> Path:
    from huggingface_hub import snapshot_download
    from huggingface_hub.errors import HFValidationError, LocalEntryNotFoundError

    at = f" --revision {revision}" if revision else ""
    try:
        return Path(snapshot_download(weights, revision=revision, local_files_only=True))
    except LocalEntryNotFoundError:
        raise InputError(
            f"'{weights}' is neither a folder nor a model on this machine. Get it with: hf download {weights}{at}"
        ) from None
    except HFValidationError:
        raise InputError(
            f"'{weights}' is not a folder: write model=hf/<folder>, or model=hf/<owner>/<model>."
        ) from None


def digest(folder: Path) -> str:
    """Return the hash of all files that affect the model's answers.

    Each file is read once: its hash is stored under its path, size and time of change. A downloaded file may be a link
    to a file whose name is its hash; then this hash is used.
    """
    files = sorted(file for file in folder.iterdir() if file.is_file() and file.suffix in DECIDING)
    known = _known()
    hashes = {_key(file): known.get(_key(file)) or _file_hash(file) for file in files}
    if not hashes.keys() <= known.keys():
        _keep({**known, **hashes})
    state = hashlib.sha256()
    for file in files:
        state.update(f"{file.name} {hashes[_key(file)]}\n".encode())
    return state.hexdigest()


def _key(file: Path) -> str:
    stat = file.stat()
    return f"{file.resolve()} {stat.st_size} {stat.st_mtime_ns}"


def _file_hash(file: Path) -> str:
    target = file.resolve()
    if target.parent.name == "blobs" and SHA256.fullmatch(target.name):
        return target.name
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()


def _known() -> dict[str, str]:
    """Return the stored hashes of weights files; if they cannot be read, {}, so that all are computed again."""
    try:
        hashes = json.loads(paths.weights_cache_file().read_bytes())
    except (OSError, ValueError):
        return {}
    return {str(key): str(value) for key, value in hashes.items()} if isinstance(hashes, dict) else {}


def _keep(hashes: dict[str, str]) -> None:
    file = paths.weights_cache_file()
    file.parent.mkdir(parents=True, exist_ok=True)
    partial = file.with_name(f"{file.name}.{os.getpid()}")
    partial.write_text(json.dumps(hashes, indent=0), encoding="utf-8")
    partial.replace(file)
