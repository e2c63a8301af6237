"""What is refused before a cluster gets any work; the cluster itself is in tests/cluster."""

from __future__ import annotations

import re
import socket
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from commands import SMALL, foundry
from foundry.errors import InputError
from foundry.models.answers.opening import open_answers
from foundry.running.dask import DaskRunner, Site, check_cache, check_folder, connected
from foundry.running.remote import RemoteSweep

FREE = ("-m", "model=scripted/random", "seed=0-1", *SMALL, "output.dir=sweep")


def sites(**hosts: str) -> dict[str, Site]:
    return {f"tcp://{name}": Site({}, host, sees=name != "blind") for name, host in hosts.items()}


def test_a_cache_in_a_file_and_a_folder_that_a_worker_does_not_see_are_refused_on_several_machines():
    check_cache(sites(a=socket.gethostname()), "answers.sqlite")
    check_cache(sites(a="one", b="two"), "postgresql://host/db")
    with pytest.raises(InputError, match="3 machines cannot share: set cache=postgresql://"):
        check_cache(sites(a="one", b="two"), "answers.sqlite")
    check_folder(sites(a="one", b="two"), Path("sweep"))
    with pytest.raises(InputError, match=r"Worker tcp://blind does not see 'sweep'.*runner\.remote=URL"):
        check_folder(sites(a="one", blind="two"), Path("sweep"))


def test_an_address_is_given_and_a_launcher_that_is_not_installed_is_named_with_those_that_are(tmp_path: Path):
    done = foundry(*FREE, "runner=dask", cwd=tmp_path)
    assert done.returncode == 2 and "runner.address has no value" in done.stderr
    done = foundry(*FREE, "hydra/launcher=basik", cwd=tmp_path)
    assert done.returncode == 2 and "Launcher 'basik' not found. Did you mean 'basic'?" in done.stderr
    with pytest.raises(InputError, match="write tcp://head:8786"):
        DaskRunner("head:8786")


@pytest.mark.parametrize(
    ("package", "extra", "use"),
    [
        ("distributed", "dask", lambda: connected("tcp://127.0.0.1:1").__enter__()),
        ("psycopg", "postgres", lambda: open_answers("postgresql://127.0.0.1/db")),
        ("fsspec.core", "remote", lambda: RemoteSweep.open("file:///nowhere")),
    ],
)
def test_a_missing_extra_says_how_to_install_it(
    package: str, extra: str, use: Callable[[], object], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=re.escape(f"pip install 'foundry-worlds[{extra}]'")):
        use()
