"""Passwords in addresses: shown by nothing, written into nothing."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from commands import foundry, succeeds
from foundry.errors import FoundryError, InputError
from foundry.expansion import settings_key
from foundry.models.base import ModelInfo
from foundry.models.ollama.ollama_server import parse_host
from foundry.running.lane import summarise
from foundry.storing.store import SweepFolder
from foundry.texts import holds_secret, without_secrets
from foundry.trust.unknown import check_models, check_settings

SECRET = "hunter2"
SMALL = ("world.agents=2", "world.steps=1", "analyze=false", "output.dir=out")
HOSTS = [f"http://me:{SECRET}@127.0.0.1:9", f"me:{SECRET}@127.0.0.1:9"]


def everything(workspace: Path) -> bytes:
    files = [file for file in workspace.rglob("*") if file.is_file()]
    return b"".join(str(file).encode() + file.read_bytes() for file in files)


@pytest.mark.parametrize("command", ["run", "plan", "doctor"])
def test_no_command_repeats_a_password_or_writes_it_down(command: str, workspace: Path):
    words = () if command == "run" else (command,)
    done = foundry(*words, "model=llama3.2", *SMALL, cwd=workspace, OLLAMA_HOST=HOSTS[0])
    shown = done.stdout + done.stderr
    assert "it must not contain a user or password" in shown
    assert SECRET not in shown and SECRET.encode() not in everything(workspace)


@given(st.text(max_size=8), st.text(max_size=8), st.sampled_from(["", "http://", "https://"]))
def test_no_address_with_a_user_is_repeated(user: str, rest: str, scheme: str):
    with pytest.raises(InputError) as caught:
        parse_host(f"{scheme}{user}:{SECRET}@{rest}")
    assert SECRET not in str(caught.value)


@pytest.mark.parametrize(
    "setting",
    [
        f"cache.path='host=h user=me password={SECRET}'",
        f"cache.path='postgresql://h/d?token={SECRET}'",
        f"runner.remote=ftp://me:{SECRET}@bucket/x",
    ],
)
def test_an_address_with_a_secret_is_refused_by_a_sweep_and_shown_by_no_command(setting: str, workspace: Path):
    runner = ("runner=dask", "runner.address=tcp://h:1") if setting.startswith("runner") else ()
    done = foundry("model=scripted/stay", *SMALL, *runner, setting, cwd=workspace)
    assert done.returncode == 2 and "contains a password" in done.stderr, done.stderr
    shown = succeeds("config", *runner, setting, cwd=workspace)
    assert "***" in shown.stdout
    assert SECRET not in done.stdout + done.stderr + shown.stdout + shown.stderr
    assert SECRET.encode() not in everything(workspace)


def test_a_setting_that_holds_an_address_is_shown_without_its_user(workspace: Path):
    for words in (("config",), ("config", "--json", f"model.server.hosts=[{HOSTS[1]!r}]")):
        done = succeeds(*words, "model=llama3.2", cwd=workspace, OLLAMA_HOST=HOSTS[1])
        assert SECRET not in done.stdout + done.stderr, done.stdout


@pytest.mark.parametrize("scheme", ["s3", "ftp", "nosuch", "postgresql"])
def test_what_cannot_be_fetched_is_one_line_without_its_password(scheme: str, workspace: Path):
    done = foundry("status", f"{scheme}://me:{SECRET}@127.0.0.1:9/x", "--fetch", "there", cwd=workspace)
    assert done.returncode in (2, 3) and len(done.stderr.splitlines()) == 1, done.stderr
    assert SECRET not in done.stdout + done.stderr


def test_what_a_record_would_reach_is_shown_without_passwords(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("OPENAI_API_KEY", "key")
    model = {"server": {"api_key_env": "OPENAI_API_KEY", "base_url": f"http://me:{SECRET}@there/v1"}}
    with pytest.raises(InputError, match=r"send the key in .* to 'http://\*\*\*@there/v1'"):
        check_models([model])
    with pytest.raises(InputError, match=r"'postgresql://there/a\?password=\*\*\*'"):
        check_settings({"cache": {"path": f"postgresql://there/a?password={SECRET}"}})


def test_the_cause_of_a_failed_run_is_recorded_without_passwords(workspace: Path):
    succeeds("model=scripted/stay", *SMALL, cwd=workspace)
    (only,) = SweepFolder.open(workspace / "out").runs()
    infos = {settings_key(only.config()["model"]): ModelInfo("stay")}
    for error in (FoundryError(f"no http://me:{SECRET}@h"), ValueError(f"no http://me:{SECRET}@h")):
        summary = summarise(only, infos, None, started="", seconds=0.0, error=error)
        assert summary.error == "no http://***@h"
        assert SECRET not in str(summary.traceback)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("at http://u:p@h/x now", "at http://***@h/x now"),
        ("at s3://key@b, ftp://a:b@c", "at s3://***@b, ftp://***@c"),
        ("postgresql://h/d?sslpassword=x&a=b", "postgresql://h/d?sslpassword=***&a=b"),
        ("no key:hunter2@host:11434, me:x@127.0.0.1", "no ***@host:11434, ***@127.0.0.1"),
        ("s3://b/k?X-Amz-Signature=ab&token=cd#e", "s3://b/k?X-Amz-Signature=***&token=***#e"),
        ("host=h password=hunter2 user=u", "host=h password=*** user=u"),
        ("host=h password = 'hunter 2'", "host=h password = ***"),
        ("mix/qwen3:4b@0-4+llama3.2@mood:calm, a max_tokens=5", "mix/qwen3:4b@0-4+llama3.2@mood:calm, a max_tokens=5"),
        ("model mix/qwen3:4b@50%+llama3.2@50% at http://h", "model mix/qwen3:4b@50%+llama3.2@50% at http://h"),
        ("http://h and me@example.org", "http://h and me@example.org"),
    ],
)
def test_only_users_and_passwords_of_addresses_are_left_out(text: str, shown: str):
    assert without_secrets(text) == shown
    assert not holds_secret(shown)
