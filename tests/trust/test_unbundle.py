"""Bundles of unknown origin: whatever they hold, nothing is written but what is declared, below one folder."""

import hashlib
import shutil
import tarfile
from collections.abc import Sequence
from pathlib import Path

import msgspec
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from commands import refusal, succeeds
from foundry.errors import InputError
from foundry.trust.manifest import FORMAT, check_names
from foundry.trust.unbundling import unpack_bundle

Member = tuple[str, bytes]
END = b"\0" * 1024


def header(name: str, size: int, kind: bytes = tarfile.REGTYPE, link: str = "") -> bytes:
    info = tarfile.TarInfo(name)
    info.size, info.type, info.linkname = size, kind, link
    return info.tobuf(tarfile.USTAR_FORMAT, "utf-8", "surrogateescape")


def padded(content: bytes) -> bytes:
    return content + b"\0" * (-len(content) % 512)


def manifest(declared: Sequence[Member], **changes: object) -> bytes:
    listed = [{"path": name, "size": len(c), "sha256": hashlib.sha256(c).hexdigest()} for name, c in declared]
    said = {"format": FORMAT, "sweep": "x", "runs": 0, "versions": {}, "git_commit": None, "files": listed}
    return msgspec.json.encode(said | changes)


def archive(said: bytes, files: Sequence[Member], end: bytes = END) -> bytes:
    members = [("manifest.json", said), *files]
    return b"".join(header(name, len(content)) + padded(content) for name, content in members) + end


def written(path: Path, content: bytes) -> Path:
    path.write_bytes(zstandard.ZstdCompressor().compress(content))
    return path


def refused(tmp_path: Path, content: bytes, limit: int = 1 << 30) -> str:
    """Unpack a bundle that must be refused; nothing may be left of it anywhere."""
    place = tmp_path / "place"
    place.mkdir(exist_ok=True)
    bundle = written(tmp_path / "bundle.tar.zst", content)
    with pytest.raises(InputError) as caught:
        unpack_bundle(bundle, place / "target", limit=limit)
    assert list(place.iterdir()) == []
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["bundle.tar.zst", "place"]
    return str(caught.value)


def test_what_is_declared_is_unpacked(tmp_path: Path):
    files = [("runs/a/steps.jsonl", b"{}\n"), ("sweep.yaml", b"x" * 1000)]
    unpack_bundle(written(tmp_path / "b", archive(manifest(files), files)), tmp_path / "out")
    texts = {p.relative_to(tmp_path / "out").as_posix() for p in (tmp_path / "out").rglob("*") if p.is_file()}
    assert texts == {"runs/a/steps.jsonl", "sweep.yaml", "manifest.json"}


@pytest.mark.parametrize(
    "name",
    ["../x", "/etc/x", "a/../../x", "a//b", "./a", "a/.", "", "C:x", "c\\x", "nul", "a/CON.txt", "a.", "b ", "x\0y",
     "a\nb", "MANIFEST.json", "x" * 300, "a\u202eb", "com1", "a/" + "y" * 210],
)  # fmt: skip
def test_a_name_that_leads_elsewhere_is_refused(name: str, tmp_path: Path):
    assert "refused" in refused(tmp_path, archive(manifest([(name, b"x")]), []))


@pytest.mark.parametrize("names", [("a", "a"), ("a", "A"), ("é", "e\u0301"), ("a", "a/b"), ("a/b", "A"), ("ß", "SS")])
def test_names_that_meet_in_one_file_are_refused(names: tuple[str, str], tmp_path: Path):
    files = [(name, b"") for name in names]
    assert "refused" in refused(tmp_path, archive(manifest(files), []))


def test_no_file_is_written_over_where_a_file_system_takes_further_names_for_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Short names of Windows are such names; here the check of names lets two that are one on any system pass."""
    monkeypatch.setattr("foundry.trust.manifest.check_names", list)
    files = [("runs/steps.jsonl", b"1"), ("runs/steps.jsonl", b"2")]
    with pytest.raises(FileExistsError):
        unpack_bundle(written(tmp_path / "bundle", archive(manifest(files), files)), tmp_path / "out")
    assert [entry.name for entry in tmp_path.iterdir()] == ["bundle"]


@pytest.mark.parametrize(
    "kind", [tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.CHRTYPE, tarfile.FIFOTYPE, tarfile.DIRTYPE, tarfile.XHDTYPE,
             tarfile.GNUTYPE_LONGNAME, tarfile.GNUTYPE_SPARSE, tarfile.CONTTYPE, tarfile.REGTYPE, b"Z"],
)  # fmt: skip
def test_anything_but_a_plain_file_without_a_link_is_refused(kind: bytes, tmp_path: Path):
    said = manifest([("a", b"")])
    content = header("manifest.json", len(said)) + padded(said) + header("a", 0, kind, link="/etc/passwd") + END
    assert "not a plain file" in refused(tmp_path, content)


def test_the_limit_of_the_command_line_is_in_gib_of_what_is_unpacked(tmp_path: Path):
    files = [("sweep.yaml", bytes(2 << 20))]
    written(tmp_path / "b.tar.zst", archive(manifest(files), files))
    assert "0.00 GiB are allowed and free. Free some space, or raise --limit" in refusal(
        "unbundle", "b.tar.zst", "--limit", "0.0019", cwd=tmp_path
    )
    assert not (tmp_path / "b").exists()
    done = succeeds("unbundle", "b.tar.zst", "--limit", "0.00196", cwd=tmp_path)
    assert (tmp_path / "b" / "sweep.yaml").stat().st_size == 2 << 20, done.stderr


TWO = [("a", b"1"), ("b", b"2")]


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (archive(manifest(TWO), [("a", b"2"), TWO[1]]), "damaged"),
        (archive(manifest(TWO), [("a", b"1" * 600), TWO[1]]), "instead of the declared 1"),
        (archive(manifest(TWO), TWO[::-1]), "instead of 'a'"),
        (archive(manifest(TWO), TWO[:1]), "its end"),
        (archive(manifest(TWO), [*TWO, ("c", b"")]), "not in its manifest"),
        (archive(manifest(TWO), TWO)[:-1500], "ends too early"),
        (archive(manifest(TWO), TWO, END + b"more"), "something follows"),
        (header("a", 1) + padded(b"1") + END, "not manifest.json"),
        (archive(manifest(TWO, format="another"), TWO), "format is 'another'"),
        (archive(manifest(TWO, files=[{"path": "a", "size": -1, "sha256": "z"}]), TWO), "is invalid"),
        (archive(b'{"versions":' + b"[" * 100_000, TWO), "cannot be read"),
    ],
    ids=lambda one: one if isinstance(one, str) else "bundle",
)
def test_a_bundle_that_is_not_what_it_says_is_refused(content: bytes, expected: str, tmp_path: Path):
    assert expected in refused(tmp_path, content)


def test_a_file_of_another_kind_is_refused_with_the_kind_that_a_bundle_has(tmp_path: Path):
    (tmp_path / "bundle.zip").write_bytes(b"PK\3\4" + b"x" * 1000)
    with pytest.raises(InputError, match=r"bundle\.zip' is refused.*\.tar\.zst"):
        unpack_bundle(tmp_path / "bundle.zip", tmp_path / "target")
    assert not (tmp_path / "target").exists()


def test_a_bomb_is_refused_before_it_is_unpacked(tmp_path: Path):
    bomb = manifest([], files=[{"path": "a", "size": 1 << 40, "sha256": "0" * 64}])
    assert "1024.00 GiB" in refused(tmp_path, archive(bomb, []))
    assert "manifest has" in refused(tmp_path, header("manifest.json", 1 << 32) + END)
    said = manifest([("a", b"")])
    hidden = header("manifest.json", len(said)) + padded(said) + header("a", 1 << 32) + b"\0" * (1 << 20)
    assert "instead of the declared 0" in refused(tmp_path, hidden)
    compressor = zstandard.ZstdCompressor(
        compression_params=zstandard.ZstdCompressionParameters.from_level(1, window_log=30)
    )
    (tmp_path / "bundle.tar.zst").write_bytes(compressor.compressobj().compress(b"x" * 5_000_000))
    with pytest.raises(InputError, match="refused"):
        unpack_bundle(tmp_path / "bundle.tar.zst", tmp_path / "place" / "target")


def test_a_folder_in_use_is_left_alone(tmp_path: Path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine").write_text("x")
    with pytest.raises(InputError, match="is not empty"):
        unpack_bundle(written(tmp_path / "b", archive(manifest([]), [])), tmp_path / "out")


parts = st.sampled_from(
    ["a", "B", "..", ".", "", "nul", "c:", "\\", "é", "e\u0301", "x.", " ", "\u202e", "\ud800", "~"]
)
hostile = st.one_of(st.lists(parts, min_size=1, max_size=4).map("/".join), st.text(max_size=12))


@given(st.lists(hostile, min_size=1, max_size=5))
def test_names_that_pass_stay_below_the_folder_and_apart(names: list[str]):
    try:
        check_names(names)
    except InputError:
        return
    root = Path("/sweep")
    resolved = [Path(f"/sweep/{name}") for name in names]
    assert all(".." not in path.parts and path.is_relative_to(root) and path != root for path in resolved)
    assert len({str(path).casefold() for path in resolved}) == len(names)
    assert not any(path in other.parents for path in resolved for other in resolved)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25)
@given(noise=st.binary(max_size=400), at=st.integers(0, 4000))
def test_no_noise_in_a_bundle_gets_anything_written(noise: bytes, at: int, tmp_path: Path):
    files = [("a", b"1"), ("b/c", b"2" * 700)]
    good = archive(manifest(files), files)
    spoilt = good[: at % len(good)] + noise + good[at % len(good) + len(noise) :]
    target = tmp_path / "out"
    try:
        unpack_bundle(written(tmp_path / "bundle", spoilt), target)
    except InputError:
        assert not target.exists()
        return
    found = {path.relative_to(target).as_posix(): path.read_bytes() for path in target.rglob("*") if path.is_file()}
    shutil.rmtree(target)
    assert found.pop("manifest.json") and found == dict(files)
