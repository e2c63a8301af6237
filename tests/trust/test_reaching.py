"""A record decides neither where keys go nor which cluster runs what is resumed; the user does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from commands import foundry
from foundry.errors import InputError
from foundry.reaching import check_models, check_settings
from openai_server import OpenAIServer
from trust.conftest import SMALL, play, runs

AWAY = "http://192.0.2.1:8000/v1"


@pytest.fixture(autouse=True)
def key(monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in ("OPENAI_BASE_URL", "DASK_SCHEDULER_ADDRESS", "FOUNDRY_CACHE", "OTHER_API_KEY"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("OPENAI_API_KEY", "sk-1234567890abcdef")


def served(base_url: str | list[str], variable: str | None = "OPENAI_API_KEY") -> dict[str, Any]:
    return {"server": {"base_url": base_url, "api_key_env": variable}}


@pytest.mark.parametrize(
    "url",
    [AWAY, [AWAY], f"http://127.0.0.1:1/v1,{AWAY}", "gpu1:8000/v1", "https://api.openai.com.evil.example/v1",
     "http://127.0.0.1.evil.example/v1", "http://127.0.0.1@evil.example/v1"],
)  # fmt: skip
def test_a_key_goes_to_no_server_that_only_the_record_names(url: str | list[str]):
    for model in (served(url), {"members": {"one": {"model": served(url)}}}):
        with pytest.raises(InputError, match="OPENAI_API_KEY sent to .*--trust-servers"):
            check_models([model])


def test_a_key_goes_to_this_machine_to_openai_and_where_the_user_says(monkeypatch: pytest.MonkeyPatch):
    check_models([served("http://127.0.0.1:8000/v1"), served("localhost:8000/v1"), served("https://api.openai.com/v1")])
    check_models([served(AWAY, None), served(AWAY, "OTHER_API_KEY")])  # no key is there
    check_models([served(AWAY)], typed=("model=openai/a", f"model.server.base_url={AWAY}"))
    check_models([served(AWAY)], recorded=served("http://127.0.0.1:8000/v1"))  # from a file of the user's
    with pytest.raises(InputError, match="only|--trust-servers"):
        check_models([served(AWAY)], typed=(f"prompt.name={AWAY}",), recorded=served(AWAY))
    monkeypatch.setenv("OPENAI_BASE_URL", AWAY)
    check_models([served(AWAY)])


@pytest.mark.parametrize(
    ("part", "key", "value"),
    [("runner", "address", "tcp://192.0.2.1:8786"), ("runner", "remote", "s3://bucket/x"),
     ("cache", "path", "postgresql://u:secret@192.0.2.1/x"), ("cache", "path", "postgresql:///x?host=192.0.2.1")],
)  # fmt: skip
def test_a_cluster_or_database_that_only_the_record_names_is_refused(part: str, key: str, value: str):
    with pytest.raises(InputError, match="The record would connect to .*--trust-servers") as refused:
        check_settings({part: {key: value}})
    assert "secret" not in str(refused.value)


def test_what_is_on_this_machine_or_in_the_environment_is_reached(monkeypatch: pytest.MonkeyPatch):
    check_settings({"runner": {"address": "tcp://127.0.0.1:8786"}, "cache": {"path": "outputs/answers.sqlite"}})
    check_settings({"runner": {"remote": "file:///tmp/x", "workers": None}, "cache": {"path": "postgresql://[::1]/x"}})
    monkeypatch.setenv("DASK_SCHEDULER_ADDRESS", "tcp://head:8786")
    check_settings({"runner": {"address": "tcp://head:8786"}})


def test_resume_and_fork_ask_before_a_key_leaves(tmp_path: Path):
    with OpenAIServer() as server:
        here = {"OPENAI_BASE_URL": server.base_url, "OPENAI_API_KEY": "sk-1234567890abcdef"}
        sweep = play(tmp_path, "model=openai/a", *SMALL, **here)
        text = (sweep / "sweep.yaml").read_text()
        (sweep / "sweep.yaml").write_text(text.replace(server.base_url, AWAY))
        (run,) = runs(sweep)
        fork = ("fork", str(run.path), "--at", "3", "analyze=false", "runner.workers=1")
        for command in (("resume", str(sweep)), fork):
            done = foundry(*command, cwd=tmp_path, OPENAI_API_KEY=here["OPENAI_API_KEY"])
            assert done.returncode == 2 and "--trust-servers" in done.stderr, done.stdout + done.stderr
            assert done.stderr.count("\n") == 1 and "sk-" not in done.stderr
        done = foundry("resume", str(sweep), cwd=tmp_path, FOUNDRY_CACHE=str(tmp_path / "answers.sqlite"), **here)
        assert done.returncode == 0, done.stderr
