"""The command view, which shows recorded runs in a browser; and pages on which people answer or label."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry.commands.application import LOOK, app
from foundry.commands.options import Browser, Host, Mine, Noted, Port, Trusted, folder_argument
from foundry.commands.printing import say_notes
from foundry.errors import InputError
from foundry.storing.store import SweepFolder, sweeps_in
from foundry.texts import counted

if TYPE_CHECKING:
    import threading

    from foundry.labels.desk import LabelDesk
    from foundry.models.human.desk import Desk


@app.command(rich_help_panel=LOOK)
def view(
    folder: Annotated[
        Path | None,
        folder_argument("A sweep's folder, or a folder of sweeps; default: the newest sweep in outputs/.", "DIR"),
    ] = None,
    export: Annotated[Path | None, typer.Option(help="Instead, write the page as files into this folder.")] = None,
    notes: Noted = False,
    host: Host = "127.0.0.1",
    port: Port = None,
    browser: Browser = True,
    trust_targets: Trusted = None,
    config_dir: Mine = None,
) -> None:
    """Look at runs in the browser: steps, prompts and replies."""
    root = folder if folder is not None else _newest()
    if export is not None:
        _export(root, export, trust_targets or (), notes=notes)
    else:
        _serve(root, host=host, port=port, browser=browser, trusted=trust_targets or ())


def check_view(asked: object) -> None:
    """Raise an error if the setting `view` has an unknown value; commands call this before they write anything."""
    if asked not in (None, "live"):
        raise InputError(f"view must be null or live; got {asked}. To look at recorded runs, use foundry view.")


@dataclass(frozen=True)
class AskingPage:
    """Serves a page to people: its address, and whether a browser opens it."""

    host: str
    port: int | None
    browser: bool

    @contextmanager
    def shown(
        self, desk: Desk, terms: str, *, leave: Callable[[], None], **watching: Callable[[], Any]
    ) -> Iterator[None]:
        """Serve the page of questions within this context, and up to a second longer if the page is open.

        Args:
            desk: the desk at which questions wait.
            terms: text that the person reads before the first question.
            leave: function that is called when the person stops answering.
            watching: the functions `look` and `far` of the server.
        """
        from foundry.viewer.http import running
        from foundry.viewer.people.people_server import PeopleServer

        with running(PeopleServer(desk, terms, leave=leave, host=self.host, port=self.port, **watching)) as server:
            self._announce("answer", server.url, "Ctrl-C ends; answers are kept")
            yield
            server.farewell()

    @contextmanager
    def labelling(self, desk: LabelDesk, title: str) -> Iterator[threading.Event]:
        """Serve the page of labels within this context; yield an event that is set once all people have ended.

        Args:
            desk: the desk at which texts wait.
            title: title of the page, such as "label: warning".
        """
        from foundry.viewer.http import running
        from foundry.viewer.people.label_server import LabelServer

        with running(LabelServer(desk, title, host=self.host, port=self.port)) as server:
            self._announce("label", server.url, "until all people have ended, or Ctrl-C; all labels are kept")
            yield server.ended

    def _announce(self, task: str, url: str, end: str) -> None:
        from foundry.viewer.http import is_loopback, open_in_browser

        if not is_loopback(self.host):
            print(f"Warning: anyone with this address can {task}, and the connection is not encrypted.")
        print(f"{task} at {url} ({end})", flush=True)
        if self.browser:
            open_in_browser(url)


def terms_for(people: Sequence[str], where: str) -> str:
    """Return the text that people read before the first question."""
    under = "this name" if len(people) == 1 else "the name shown with each question"
    return (
        f"You answer as {' and '.join(people)}. Your answers are recorded under {under}, with the seconds that each "
        f"answer took, in the sweep '{where}' and in its cache of answers.\n"
        "Nothing else about you is recorded. You may stop at any time and go on another day; your answers are kept.\n"
        "If you agree to this, begin."
    )


@contextmanager
def watched(folder: SweepFolder, asked: object) -> Iterator[None]:
    """Serve the page of a running sweep within this context, if the setting `view` asks for it."""
    if asked is None:
        yield
        return
    from foundry.viewer.http import open_in_browser
    from foundry.viewer.live import serve_live

    worlds = {str(condition.config["world"].get("_target_")) for condition in folder.sweep.conditions}
    with serve_live(folder.path, sorted(world.rpartition(".")[0] for world in worlds)) as url:
        print(f"watch at {url}", flush=True)
        open_in_browser(url)
        yield


def _newest() -> Path:
    outputs = Path("outputs")
    if not outputs.is_dir():
        raise InputError("No folder outputs/ here. Name a sweep's folder, as in foundry view DIR.")
    return sweeps_in(outputs)[0]


def _export(root: Path, out: Path, trusted: Sequence[str], *, notes: bool) -> None:
    from foundry.viewer.export import export

    exported = export(root, out, trusted, notes=notes, is_warning=_is_warning)
    size = f"{counted(exported.runs, 'run')} in {counted(exported.files, 'file')}, {exported.size / 1e6:,.1f} MB"
    print(f"{size}: open {exported.page}")
    say_notes(sweeps_in(root), taken=notes)


def _is_warning(text: str, fires: tuple[str, ...]) -> bool | None:
    from analysis.labelling.warning_rule import is_warning

    return is_warning(text, fires)


def _serve(root: Path, *, host: str, port: int | None, browser: bool, trusted: Sequence[str]) -> None:
    from foundry.viewer.http import is_loopback, open_in_browser
    from foundry.viewer.server import ViewServer

    server = ViewServer(root, host=host, port=port, trusted=trusted, is_warning=_is_warning)
    if not is_loopback(host):
        print(f"Warning: anyone who can open {host} can read every prompt and reply in '{root}'.")
    print(f"{root} is shown at {server.url} (Ctrl-C ends)", flush=True)
    if browser:
        open_in_browser(server.url)
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        print("ended")
    finally:
        server.server_close()
