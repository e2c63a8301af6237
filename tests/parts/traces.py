"""Takes back what a command or a test changes in its process, so that the next one finds it as the first one did."""

import contextlib
import logging
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

_PLACES = frozenset(Path(place).absolute() for place in sys.path)
"""Where the modules are that all tests share; whatever else is imported is a user's own."""
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_FOUND_OUT = "_FOUNDRY_RENDERING_WORKS"
"""The variable that stays: what one test found out, the next need not."""
_REMEMBERING = {"foundry.own_code": "_imported", "analysis.form": "_form_of", "analysis.signatures": "_discover"}
"""Functions, by their modules, that remember what they made of a user's own modules."""
_PREFIXES = ("OLLAMA_", "OPENAI_", "HF_", "FOUNDRY_", "HYDRA_", "_FOUNDRY")


@contextlib.contextmanager
def no_traces() -> Iterator[None]:
    """Undo what is done meanwhile to the environment, the path, a user's own modules, signals and logging."""
    environment, path, modules = dict(os.environ), list(sys.path), list(sys.modules)
    handled = [signal.getsignal(one) for one in _SIGNALS]
    loggers = [(one, one.level, list(one.handlers)) for one in (logging.getLogger(), logging.getLogger("foundry"))]
    try:
        yield
    finally:
        if list(sys.modules) != modules:  # is found out in a tenth of the time that the difference takes
            _forget([name for name in set(sys.modules).difference(modules) if _is_own(name)])
        sys.path[:] = path
        for name, _ in dict(os.environ).items() ^ environment.items():
            if name != _FOUND_OUT:
                _set(name, environment.get(name))
        for one, handler in zip(_SIGNALS, handled, strict=True):
            if signal.getsignal(one) is not handler:
                signal.signal(one, handler)
        for logger, level, handlers in loggers:
            logger.setLevel(level)
            logger.handlers[:] = handlers


def without_settings() -> None:
    """Take every variable out of the environment that decides what foundry or what it calls does."""
    for name in set(os.environ) - {_FOUND_OUT}:
        if name.startswith(_PREFIXES) or name.lower().endswith("_proxy"):
            del os.environ[name]


def _set(name: str, value: str | None) -> None:
    if value is None:
        os.environ.pop(name, None)
    else:
        os.environ[name] = value


def _is_own(name: str) -> bool:
    module = sys.modules.get(name.partition(".")[0])
    places = [Path(one) for one in (*getattr(module, "__path__", ()), getattr(module, "__file__", None)) if one]
    return bool(places) and not any(place.parent in _PLACES or place.is_relative_to(sys.prefix) for place in places)


def _forget(modules: list[str]) -> None:
    """Forget modules, and with them the objects that foundry made of them."""
    for name in modules:
        del sys.modules[name]
    for name, function in _REMEMBERING.items() if modules else ():
        remembering = getattr(sys.modules.get(name), function, None)  # the thread of a server may just import it
        if remembering is not None:
            remembering.cache_clear()
