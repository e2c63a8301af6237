"""The manifest of a bundle, which lists its files with sizes and digests; and the rules for names of files."""

import re
import unicodedata
from collections.abc import Iterable
from pathlib import Path, PurePosixPath
from typing import Any

import msgspec

from foundry.errors import InputError
from foundry.storing.plain import is_there, plain

NAME = "manifest.json"
FORMAT = "foundry-bundle-1"
LARGEST_BYTES = 256 * 1024 * 1024
"""Maximum size of the manifest, bytes."""
MOST_FILES = 2_000_000
_LONGEST_NAME, _LONGEST_PART = 240, 200
_SHA256 = re.compile(r"[0-9a-f]{64}")
_FORBIDDEN = re.compile(r'[\x00-\x1f\x7f<>:"|?*\\]')
_DEVICES = re.compile(r"(?:con|prn|aux|nul|conin\$|conout\$|com[0-9¹²³]|lpt[0-9¹²³])(?:\..*)?", re.IGNORECASE)


class BundledFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A file in a bundle; its size is in bytes."""

    path: str
    size: int
    sha256: str


class Manifest(msgspec.Struct, frozen=True, kw_only=True):
    """The list of the files in a bundle, which is its first file.

    Attributes:
        format: version of the format.
        sweep: name of the sweep's folder.
        versions: versions of foundry, Python and the packages that can change a record, where the bundle was made.
        git_commit: commit of foundry's clone there, or null.
        files: all other files of the bundle, in their order.
    """

    format: str
    sweep: str
    runs: int
    versions: dict[str, Any]
    git_commit: str | None
    files: tuple[BundledFile, ...]


def read_manifest(content: bytes) -> Manifest:
    """Decode and check the manifest of a bundle."""
    try:
        manifest = msgspec.json.decode(content, type=Manifest)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"The bundle is refused: its manifest cannot be read: {error}.") from error
    if manifest.format != FORMAT:
        raise InputError(f"The bundle is refused: its format is '{manifest.format}'; this foundry reads '{FORMAT}'.")
    if len(manifest.files) > MOST_FILES:
        raise InputError(f"The bundle is refused: it lists more than {MOST_FILES:,} files.")
    for file in manifest.files:
        if file.size < 0 or not _SHA256.fullmatch(file.sha256):
            raise InputError(f"The bundle is refused: size or digest of {file.path!r} is invalid.")
    check_names(file.path for file in manifest.files)
    return manifest


def bundled_runs(folder: Path) -> frozenset[str]:
    """Return the ids of the runs that had ended when this folder was bundled; none if it comes from no bundle."""
    file = plain(folder / NAME)
    if not is_there(file):
        return frozenset()
    paths = [PurePosixPath(bundled.path).parts for bundled in read_manifest(file.read_bytes()).files]
    return frozenset(path[1] for path in paths if path[0] == "runs" and path[2:] == ("run.json",))


def check_names(names: Iterable[str]) -> None:
    """Reject names that lead out of the folder, that some file system cannot store, or that mean the same file."""
    seen: dict[str, str] = {_folded(NAME): NAME}
    folders: dict[str, str] = {}
    for name in names:
        why = _objection(name)
        if why:
            raise InputError(f"The bundle is refused: the file name {name!r} {why}.")
        folded = _folded(name)
        if folded in seen:
            raise InputError(f"The bundle is refused: the names {name!r} and {seen[folded]!r} mean the same file.")
        seen[folded] = name
        for parent in PurePosixPath(folded).parents:
            folders.setdefault(str(parent), name)
    both = seen.keys() & folders.keys()
    if both:
        raise InputError(f"The bundle is refused: {seen[min(both)]!r} is both a file and a folder.")


def _folded(name: str) -> str:
    """Return the same text for all names that some file system takes for one file, such as "a" and "A"."""
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", name).casefold())


def _objection(name: str) -> str:
    if not name or len(name.encode("utf-8", "surrogatepass")) > _LONGEST_NAME:
        return "is empty or too long"
    if _FORBIDDEN.search(name) or any(unicodedata.category(letter) in ("Cs", "Cf") for letter in name):
        return "has a character that some file systems cannot hold"
    for part in name.split("/"):
        if part in ("", ".", ".."):
            return "is not a plain path below the folder"
        if part != part.rstrip(" ."):
            return "has a part that ends with a dot or a space"
        if len(part.encode()) > _LONGEST_PART or _DEVICES.fullmatch(part):
            return "has a part that is too long or the name of a device"
    return ""
