"""A real PostgreSQL server of a test's own, where PostgreSQL is installed."""

import contextlib
import getpass
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ports import reserved_port

ACCOUNT = "postgres"
"""PostgreSQL refuses to run as root; this account comes with its packages."""
WAITING = ("--wait", "--silent", "--timeout=3600")  # unless told, it gives up after a minute


def programs() -> Path | None:
    """Return the folder of PostgreSQL's programs, or None where it is not installed."""
    found = shutil.which("initdb")
    places = (
        [Path(found).resolve().parent] if found else sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True)
    )
    return next((place for place in places if (place / "createdb").exists()), None)


class PostgresServer:
    """A server at a port whose data is gone afterwards."""

    def __init__(self, programs: Path, folder: Path, port: int) -> None:
        self._programs = programs
        self._folder = folder
        self._account: dict[str, Any] = {"user": ACCOUNT, "group": ACCOUNT} if os.geteuid() == 0 else {}
        self.user = ACCOUNT if self._account else getpass.getuser()
        self.port = port
        self._databases = 0

    def create(self) -> None:
        self._call("initdb", "--auth=trust", "--no-sync", "--encoding=UTF8", f"--username={self.user}")

    def start(self) -> None:
        options = f"-p {self.port} -k {self._folder} -c listen_addresses=127.0.0.1 -c fsync=off"
        self._call("pg_ctl", "start", *WAITING, f"--log={self._folder / 'log'}", f"--options={options}")

    def stop(self) -> None:
        self._call("pg_ctl", "stop", *WAITING, "--mode=fast")

    def restart(self) -> None:
        self.stop()
        self.start()

    def database(self) -> str:
        self._databases += 1
        name = f"test{self._databases}"
        options = [f"--host={self._folder}", f"--port={self.port}", f"--username={self.user}", name]
        subprocess.run([self._programs / "createdb", *options], check=True, capture_output=True)
        return f"postgresql://{self.user}@127.0.0.1:{self.port}/{name}"

    def _call(self, program: str, *options: str) -> None:
        command = [self._programs / program, f"--pgdata={self._folder / 'data'}", *options]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, cwd=self._folder, **self._account)


@contextlib.contextmanager
def postgres_server(programs: Path) -> Iterator[PostgresServer]:
    """Run a server; the folder is not below pytest's, which other accounts cannot enter."""
    with tempfile.TemporaryDirectory(prefix="foundry-postgres-") as folder, reserved_port() as port:
        server = PostgresServer(programs, Path(folder), port)
        if os.geteuid() == 0:
            shutil.chown(folder, ACCOUNT, ACCOUNT)
        server.create()
        server.start()
        try:
            yield server
        finally:
            server.stop()
