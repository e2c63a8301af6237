"""Every command of development, each with all its set-up; needs nothing but Python and pip.

python tasks.py COMMAND...    where COMMAND is one of those below; run without one for the list.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import venv
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
GL_PACKAGES = ("libegl1", "libgl1-mesa-dri")
CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
FIREFOX = ("firefox-esr", "firefox")
EVERYTHING = "not (exhaustive or real_server or cluster or exports or firefox)"
REST = f"(slow or browser or local_models) and {EVERYTHING}"
LOCAL_MODELS = ("torch==2.13.0", "transformers>=5.0")


def call(program: str, *arguments: str) -> None:
    """Run a program of the virtual environment; if it fails, exit with its code."""
    end(start(program, *arguments))


def start(program: str, *arguments: str) -> subprocess.Popen[bytes]:
    """Start a program of the virtual environment."""
    sys.stdout.write(f"$ {' '.join([program, *arguments])}\n")
    sys.stdout.flush()
    return subprocess.Popen([BIN / program, *arguments], cwd=ROOT, env=environment())


def end(process: subprocess.Popen[bytes]) -> None:
    """Wait for a program to end; if it fails, exit with its code."""
    code = process.wait()
    if code != 0:
        sys.exit(code)


def environment() -> dict[str, str]:
    """Return the environment variables without the one that forbids bytecode, since tests start many processes."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


def call_tests(*arguments: str, processes: int = 2) -> None:
    """Run tests in several processes; all tests of a folder run in the same process (see tests/conftest.py)."""
    call("python", "-m", "compileall", "-q", "foundry", "analysis", "hydra_plugins")
    call("python", "-m", "pytest", "-n", str(processes), "--dist", "loadscope", *arguments)


def pip_install(*packages: str) -> tuple[str, ...]:
    """Return the arguments of Python that install packages, which are compiled when they are first imported."""
    return ("-m", "pip", "install", "--quiet", "--no-compile", *packages)


def install(extra: str = "") -> None:
    """Make .venv and install foundry there, editable, with an extra; do nothing if pyproject.toml has not changed."""
    wanted = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    stamps = [VENV / f"installed-{kind}" for kind in {extra or "plain", "dev"}]
    if any(stamp.exists() and stamp.read_text(encoding="utf-8") == wanted for stamp in stamps):
        return
    if not BIN.exists():
        venv.create(VENV, with_pip=True, upgrade_deps=True)  # an older pip takes twice as long for all that follows
    call("python", *pip_install("--editable", f".[{extra}]" if extra else "."))
    (VENV / f"installed-{extra or 'plain'}").write_text(wanted, encoding="utf-8")


def develop() -> None:
    """Install the packages that the linter, the type checker and the tests need."""
    install("dev")
    ensure_rendering()


def setup() -> None:
    """Install foundry in .venv, and, if this user may, the system's library that draws 3D scenes."""
    install()
    ensure_rendering()


def ensure_rendering() -> None:
    """Install the system's library that draws 3D scenes, if it is missing; if that fails, print how to install it."""
    stamp = VENV / "draws"
    if stamp.exists():
        return
    if not draws():
        install_packages(*GL_PACKAGES)
    if draws():
        stamp.touch()
    else:
        sys.stdout.write(f"3D worlds need a system library: sudo apt-get install {' '.join(GL_PACKAGES)}\n")


def ensure_browser(names: tuple[str, ...] = CHROMIUM) -> None:
    """Install a browser for the tests of pages, if none of these is installed; if that fails, print how to."""
    if any(map(shutil.which, names)):
        return
    install_packages(names[0])
    if not any(map(shutil.which, names)):
        sys.stdout.write(f"Tests of pages are skipped without their browser: sudo apt-get install {names[0]}\n")


def install_packages(*names: str) -> None:
    """Install packages of the system with apt-get, if this user may."""
    if shutil.which("apt-get") and hasattr(os, "geteuid") and os.geteuid() == 0:
        subprocess.run(["apt-get", "update", "-qq"], check=False)
        subprocess.run(["apt-get", "install", "-y", "-qq", *names], check=False)


def draws() -> bool:
    """Return whether this machine can draw a 3D scene."""
    probe = "from foundry.worlds.camera.eye.devices import check_rendering; check_rendering()"
    return subprocess.run([str(BIN / "python"), "-c", probe], capture_output=True, check=False).returncode == 0


def smoke() -> None:
    """Play, analyse and compare a small sweep of scripted models."""
    install()
    folder = tempfile.mkdtemp(prefix="foundry-smoke-")
    call("foundry", "+sweep=first", "model=scripted/random,scripted/avoid", f"output.dir={folder}/sweep")


def test() -> None:
    """Run the tests."""
    develop()
    call_tests()


def pages() -> None:
    """Run the tests that open pages in a browser."""
    develop()
    ensure_browser()
    call_tests("-m", "browser and not exhaustive")


def firefox() -> None:
    """Run the tests that use the most important pages in Firefox."""
    develop()
    ensure_browser(FIREFOX)
    call("python", "-m", "pytest", "-n", "0", "-m", "firefox")


def rest() -> None:
    """Run the tests of whole sweeps, killed processes, pages and local models; installs PyTorch, which is large."""
    develop()
    ensure_browser()
    install_local_models()
    call_tests("-m", REST, processes=3)  # many wait for a browser or a process


def everything() -> None:
    """Run check, smoke, test and rest, as `.ci/run` does."""
    develop()
    ensure_browser()
    with start("mypy") as types:
        lint()
        install_local_models()
        smoke()
    end(types)
    call_tests("-m", EVERYTHING, processes=3)


def exhaustive() -> None:
    """Run the longest tests: every scene, and thousands of examples; takes ten minutes."""
    develop()
    ensure_browser()
    call_tests("-m", "exhaustive and not (real_server or cluster or local_models or exports or firefox)")


def cluster() -> None:
    """Install Dask, PostgreSQL and Hydra's launchers, and run the tests of clusters."""
    install_cluster()
    call("python", "-m", "pytest", "-n", "0", "-m", "cluster")


def install_cluster() -> None:
    """Install the packages that sweeps on several machines need."""
    develop()
    if not shutil.which("initdb") and not list(Path("/usr/lib/postgresql").glob("*/bin")):
        install_packages("postgresql")
    launchers = ("hydra-submitit-launcher", "hydra-joblib-launcher")
    call("python", *pip_install("--editable", ".[dev,dask,postgres,remote]", *launchers))


def install_local_models() -> None:
    """Install PyTorch and transformers."""
    call("python", *pip_install(*LOCAL_MODELS))


def local_models() -> None:
    """Install PyTorch and transformers, which are large, and run the tests of local models."""
    develop()
    install_local_models()
    call("python", "-m", "pytest", "-m", "local_models")


def servers() -> None:
    """Install the server of llama.cpp, and run the tests against it."""
    develop()
    call("python", *pip_install("xllamacpp", "gguf", "tokenizers"))
    call("python", "-m", "pytest", "-n", "0", "-m", "real_server")


def exports() -> None:
    """Install the tools that read exports, and run the tests that open exports with these tools."""
    develop()
    ensure_browser()
    call("python", *pip_install("--editable", ".[dev,inspect,eee]", "polars"))
    call("python", "-m", "pytest", "-n", "0", "-m", "exports")


def check() -> None:
    """Run the linter, the formatter's check and the type checker."""
    install("dev")
    lint()
    call("mypy")


def lint() -> None:
    """Run the linter and the formatter's check."""
    call("ruff", "check", ".")
    call("ruff", "format", "--check", ".")


def bench() -> None:
    """Run all benchmarks, and print the figures of benchmarks/README.md; takes 45 minutes."""
    install_cluster()
    install_local_models()
    ensure_browser()
    for script in sorted((ROOT / "benchmarks").glob("bench_*.py")):
        call("python", str(script.relative_to(ROOT)))


def docs() -> None:
    """Build the documentation as a site in site/, which needs no network; fail at a dead link."""
    develop()
    call("python", *pip_install("--editable", ".[dev,docs]"))
    call("mkdocs", "build", "--strict")


def packages() -> None:
    """Print the folders of code with their files and lines, and the imports between packages."""
    develop()
    call("python", "benchmarks/packages.py")


COMMANDS: dict[str, Callable[[], None]] = {
    "setup": setup,
    "smoke": smoke,
    "test": test,
    "pages": pages,
    "firefox": firefox,
    "rest": rest,
    "everything": everything,
    "exhaustive": exhaustive,
    "cluster": cluster,
    "local-models": local_models,
    "servers": servers,
    "exports": exports,
    "check": check,
    "bench": bench,
    "docs": docs,
    "packages": packages,
}


def main(names: list[str]) -> None:
    """Run the named commands in their order."""
    unknown = [name for name in names if name not in COMMANDS]
    if not names or unknown:
        lines = [f"  {name:12} {task.__doc__}" for name, task in COMMANDS.items()]
        sys.exit("\n".join(["usage: python tasks.py COMMAND...", *lines]))
    for name in names:
        COMMANDS[name]()


if __name__ == "__main__":
    main(sys.argv[1:])
