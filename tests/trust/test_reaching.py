"""A record decides neither where keys go nor which cluster runs what is resumed; the user does."""

from pathlib import Path
from typing import Any

import pytest

from commands import refusal, succeeds
from foundry.errors import InputError
from foundry.expansion import Condition, Sweep, expand, models_in, with_hosts
from foundry.trust.unknown import check_models, check_settings
from openai_server import OpenAIServer
from trust.conftest import SMALL, play, rewrite, runs

AWAY = "http://192.0.2.1:8000/v1"
OPENAI, MIXED = "foundry.models.openai.openai_model.OpenAIModel", "foundry.models.mixed.MixedModel"


@pytest.fixture(autouse=True)
def key(monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in ("OPENAI_BASE_URL", "DASK_SCHEDULER_ADDRESS", "FOUNDRY_CACHE", "OTHER_API_KEY"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("OPENAI_API_KEY", "sk-1234567890abcdef")


def served(base_url: str | list[str], variable: str | None = "OPENAI_API_KEY") -> dict[str, Any]:
    return {"_target_": OPENAI, "server": {"base_url": base_url, "api_key_env": variable}}


def mixed(model: dict[str, Any]) -> dict[str, Any]:
    return {"_target_": MIXED, "name": "mix", "members": {"one": {"model": model, "share": 1}}}


def wrapped(model: dict[str, Any]) -> dict[str, Any]:
    return {"_target_": "foundry.models.wrappers.cached.WarmedModel", "inner": model}


@pytest.mark.parametrize(
    "url",
    [AWAY, [AWAY], f"http://127.0.0.1:1/v1,{AWAY}", "gpu1:8000/v1", "https://api.openai.com.evil.example/v1",
     "http://127.0.0.1.evil.example/v1", "http://127.0.0.1@evil.example/v1", "http://127.0.0.1:secret@evil.example/v1"],
)  # fmt: skip
def test_a_key_goes_to_no_server_that_only_the_record_names(url: str | list[str]):
    deep = wrapped(mixed(served(url)))
    for model in (served(url), mixed(served(url)), mixed(mixed(served(url))), deep, mixed({"deep": [deep]})):
        with pytest.raises(InputError, match="send the key in OPENAI_API_KEY to .*--trust-servers") as refused:
            check_models([model])
        assert "secret" not in str(refused.value)


def test_a_key_goes_to_this_machine_to_openai_and_where_the_user_says(monkeypatch: pytest.MonkeyPatch):
    check_models([served("http://127.0.0.1:8000/v1"), served("localhost:8000/v1"), served("https://api.openai.com/v1")])
    check_models([served("http://127.0.0.53/v1"), served(" https://api.openai.com/v1, ,http://[::1]:1/v1 ,")])
    check_models([served(AWAY, None), served(AWAY, "OTHER_API_KEY")])  # no key is there
    check_models([served(AWAY)], typed=("model=openai/a", f"model.server.base_url={AWAY}"))
    check_models([served(AWAY)], recorded=[served("http://127.0.0.1:8000/v1")])  # not the record's
    with pytest.raises(InputError, match="only|--trust-servers"):
        check_models([served(AWAY)], typed=(f"prompt.name=base_url {AWAY}",), recorded=[served(AWAY)])
    monkeypatch.setenv("OPENAI_BASE_URL", AWAY)
    check_models([served(AWAY), served(f"{AWAY} ,")])


@pytest.mark.parametrize(
    ("part", "key", "value"),
    [("runner", "address", "tcp://192.0.2.1:8786"), ("runner", "remote", "s3://bucket/x"),
     ("cache", "path", "postgresql://u:secret@192.0.2.1/x"), ("cache", "path", "postgresql:///x?host=192.0.2.1"),
     ("cache", "path", "postgresql://127.0.0.1/x?host=192.0.2.1")],
)  # fmt: skip
def test_a_cluster_or_database_that_only_the_record_names_is_refused(part: str, key: str, value: str):
    with pytest.raises(InputError, match="The record would connect to .*--trust-servers") as refused:
        check_settings({part: {key: value}})
    assert "secret" not in str(refused.value)


def test_what_is_on_this_machine_or_in_the_environment_is_reached(monkeypatch: pytest.MonkeyPatch):
    check_settings({"runner": {"address": "tcp://127.0.0.1:8786"}, "cache": {"path": "outputs/answers.sqlite"}})
    check_settings({"runner": {"remote": "file:///tmp/x", "workers": None}, "cache": {"path": "postgresql://[::1]/x"}})
    monkeypatch.setenv("DASK_SCHEDULER_ADDRESS", "tcp://head:8786")
    monkeypatch.setenv("FOUNDRY_CACHE", "postgresql://head/x")
    check_settings({"runner": {"address": "tcp://head:8786"}, "cache": {"path": "postgresql://head/x"}})


def test_resume_and_fork_ask_before_a_key_leaves(tmp_path: Path):
    with OpenAIServer() as server:
        here = {"OPENAI_BASE_URL": server.base_url, "OPENAI_API_KEY": "sk-1234567890abcdef"}
        sweep = play(tmp_path, "model=openai/a", *SMALL, **here)
        received = len(server.headers)
        text = (sweep / "sweep.yaml").read_text()
        away = server.base_url.replace("127.0.0.1", "0.0.0.0")  # reaches this machine, and does not say so
        (sweep / "sweep.yaml").write_text(text.replace(server.base_url, away))
        (run,) = runs(sweep)
        fork = ("fork", str(run.path), "--at", "3", "analyze=false", "runner.workers=1")
        for command in (fork, ("resume", str(sweep))):
            (run.path / "run.json").unlink(missing_ok=True)
            line = refusal(*command, cwd=tmp_path, OPENAI_API_KEY=here["OPENAI_API_KEY"])
            assert "--trust-servers" in line and "sk-" not in line
        assert len(server.headers) == received
        succeeds("resume", str(sweep), cwd=tmp_path, FOUNDRY_CACHE=str(tmp_path / "answers.sqlite"), **here)


@pytest.mark.slow
def test_a_probe_sends_no_key_where_any_condition_of_the_record_leads(tmp_path: Path):
    with OpenAIServer() as server:
        here = {"OPENAI_BASE_URL": server.base_url, "OPENAI_API_KEY": "sk-1234567890abcdef"}
        sweep = play(tmp_path, "-m", "model=scripted/stay,openai/a", *SMALL, **here)
        away = server.base_url.replace("127.0.0.1", "0.0.0.0")
        (sweep / "sweep.yaml").write_text((sweep / "sweep.yaml").read_text().replace(server.base_url, away))
        (runs(sweep)[0].path / "run.json").unlink()
        received = len(server.headers)
        asked = (str(sweep), "-m", "edit=no_fire", "moments=1", "repeats=1", "output.dir=made")
        for command in (("probe", *asked), ("preregister", *asked, "--family", "no_fire")):
            assert "--trust-servers" in refusal(*command, cwd=tmp_path, OPENAI_API_KEY=here["OPENAI_API_KEY"])
        assert len(server.headers) == received
        succeeds(*command, "--trust-servers", cwd=tmp_path)


def test_a_key_goes_where_the_users_own_configuration_leads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "foundry").mkdir()
    (tmp_path / "foundry" / "config.yaml").write_text("model.server.base_url: http://one/v1\n")
    (tmp_path / "mine" / "model").mkdir(parents=True)
    (tmp_path / "mine" / "model" / "lab.yaml").write_text("server: {base_url: [http://two/v1, http://three/v1]}\n")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("FOUNDRY_MINE", str(tmp_path / "mine"))
    check_models(map(served, ("http://one/v1", "http://two/v1", "http://three/v1")))
    with pytest.raises(InputError, match="--trust-servers"):
        check_models([served("http://four/v1")])


def test_a_wrapper_is_not_for_a_record_to_name(tmp_path: Path):
    sweep = play(tmp_path, "model=scripted/stay", *SMALL)
    rewrite(sweep, lambda content: content["conditions"][0]["config"]["model"].update(wrapped({})))
    assert "WarmedModel' is refused: it wraps other models" in refusal("resume", str(sweep), cwd=tmp_path)


def deep_sweep(base_url: str) -> Sweep:
    config = {**dict.fromkeys(("world", "prompt"), {"name": "any"}), "sampling_seed": None}
    return expand([], [Condition({}, {**config, "model": mixed(mixed(served(base_url)))}, (0,))])


def test_how_a_model_deep_in_another_is_reached_is_changed_and_decides_no_run():
    sweep, other = deep_sweep("http://one/v1"), deep_sweep("http://other/v1")
    assert [run.id for run in sweep.runs] == [run.id for run in other.runs]
    moved = with_hosts(sweep, "http://new/v1", "base_url").conditions[0].config["model"]
    assert [part["server"]["base_url"] for part in models_in(moved) if "server" in part] == ["http://new/v1"]


def test_the_database_that_only_a_record_names_labels_nothing(tmp_path: Path):
    sweep = play(tmp_path, "model=scripted/herd", *SMALL)
    rewrite(sweep, lambda content: content["settings"].update(cache={"path": "postgresql://192.0.2.1/answers"}))
    line = refusal("label", str(sweep), "--model", "scripted/stay", cwd=tmp_path)
    assert "The record would connect to" in line and "--trust-servers" in line
