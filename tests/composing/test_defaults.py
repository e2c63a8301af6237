"""A user's own defaults: below all that is asked for, recorded where they decide, never silent."""

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
import yaml

from commands import foundry, refusal, succeeds
from foundry.composing.compose import Composed, compose
from foundry.composing.defaults import read_defaults
from foundry.errors import InputError, RecordError
from foundry.paths import user_config_file

TINY = ("world.agents=3", "world.steps=2", "analyze=false")
SCRIPTED = "model=scripted/random,scripted/avoid"
Write = Callable[[str], Path]


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    """Writes the user's file, in a home of its own."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "home"))

    def write(text: str) -> Path:
        file = user_config_file()
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        return file

    return write


def composed(*argv: str) -> Composed:
    found = compose(argv, read_defaults())
    assert found is not None
    return found


def test_the_users_file_lies_where_the_system_keeps_such_files_and_an_empty_one_changes_nothing(
    own: Write, tmp_path: Path
):
    without = composed("model=scripted/random")
    assert own("# nothing yet\n") == tmp_path / "home" / "foundry" / "config.yaml"
    assert composed("model=scripted/random") == without


def test_dotted_and_nested_settings_take_the_place_of_shipped_ones_but_not_from_python(own: Write):
    own("model: llama3.2\nmodel.server.keep_alive: 5m\nrunner: {open_runs: 4}\ncache.path: mine.sqlite\n")
    found = composed("world=bar")
    model = found.conditions[0].config["model"]
    assert (model["name"], model["server"]["keep_alive"]) == ("llama3.2", "5m")
    assert (found.settings["runner"]["open_runs"], found.settings["cache"]["path"]) == (4, "mine.sqlite")
    from_python = compose(["model=scripted/random"])
    assert from_python.settings["runner"]["open_runs"] == 16


def test_the_command_line_stands_above_the_users_file(own: Write):
    own("model: llama3.2\ncache.path: mine.sqlite\nmodel.server.keep_alive: 5m\nrunner.workers: 3\n")
    argv = ("-m", "model=qwen3:4b", "cache.path=other.sqlite", "model.server.keep_alive=1m", "runner.workers=2")
    found = composed(*argv)
    model = found.conditions[0].config["model"]
    assert (model["name"], model["server"]["keep_alive"]) == ("qwen3:4b", "1m")
    assert (found.settings["cache"]["path"], found.settings["runner"]["workers"]) == ("other.sqlite", 2)
    assert found.chosen == () and found.asked == argv


@pytest.mark.slow
def test_a_named_sweep_and_a_world_that_chooses_stand_above_the_users_file(own: Write):
    own("analyze: false\nprompt: json\n")
    assert composed("+sweep=validation").settings["analyze"] == "baselines"
    assert composed("world=bar", "model=scripted/random").conditions[0].config["prompt"]["name"] == "bar"
    assert composed("model=scripted/random").conditions[0].config["prompt"]["name"] == "json"


def test_what_a_named_sweep_varies_is_not_recorded_as_asked_by_the_users_file(own: Write):
    own("model: scripted/avoid\n")
    assert composed("+sweep=first", SCRIPTED).asked == ("+sweep=first", SCRIPTED)


def test_a_default_of_servers_is_none_of_models_without_one(own: Write):
    own("model.server.hosts: http://127.0.0.1:9\n")
    found = composed("-m", "model=scripted/stay,llama3.2,mix/llama3.2@50%+scripted/stay@50%")
    plain, served, mixed = (condition.config["model"] for condition in found.conditions)
    assert "server" not in plain and served["server"]["hosts"] == "http://127.0.0.1:9"
    assert mixed["members"]["m1"]["model"]["server"]["hosts"] == "http://127.0.0.1:9"
    assert found.chosen == ()


def test_a_folder_of_ones_own_that_is_not_there_is_told_as_without_a_users_file(own: Write, tmp_path: Path):
    own("model.server.keep_alive: 5m\n")
    finished = foundry("--config-dir", "nosuch", "model=scripted/random", *TINY, cwd=tmp_path)
    assert (finished.returncode, finished.stderr.count("\n")) == (2, 1) and "nosuch' not found" in finished.stderr


def test_a_part_of_the_users_file_is_recorded_as_if_it_had_been_asked(own: Write):
    own("model: llama3.2\nmodel.server.keep_alive: 5m\ncache.path: mine.sqlite\n")
    found = composed("seed=3")
    assert found.asked == ("model=llama3.2", "seed=3")
    typed = compose(found.asked)
    assert [run.id for run in typed.sweep.runs] == [run.id for run in found.sweep.runs]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("modle: llama3.2", "setting 'modle' not found. Did you mean 'model'?"),
        ("model.server.hots: x", "setting 'model.server.hots' not found. Did you mean 'model.server.hosts'?"),
        ("model.server: x", "setting 'model.server' not found."),
        ("world: {agents: 7}", "setting 'world.agents' not found."),
        ("world._target_: os.system", "setting 'world._target_' not found."),
        ("hydra.run.dir: x", "setting 'hydra.run.dir' not found."),
        ("- a", "contains no settings"),
        ("a: [", "cannot be read"),
        ("cache.path: ${nowhere}", "cannot be used: Interpolation key 'nowhere' not found"),
    ],
)
def test_a_setting_that_cannot_be_is_one_clear_line(own: Write, text: str, says: str):
    file = own(text)
    with pytest.raises((InputError, RecordError)) as raised:
        read_defaults()
    assert str(file) in str(raised.value) and says in str(raised.value) and "\n" not in str(raised.value)


def test_an_option_that_does_not_exist_is_told_with_its_file(own: Write):
    file = own("prompt: papper")
    with pytest.raises(InputError, match="Did you mean 'paper'") as raised:
        composed("model=scripted/stay")
    assert str(raised.value).endswith(f"Your defaults in {file} name this option.")


def test_a_sweep_says_what_it_took_from_the_users_file_and_records_it(own: Write, tmp_path: Path):
    file = own("model: scripted/stay\noutput.dir: out\n")
    done = foundry(*TINY, cwd=tmp_path)
    assert done.stderr == f"model=scripted/stay (from {file})\n"
    assert yaml.safe_load((tmp_path / "out" / "sweep.yaml").read_text())["asked"] == ["model=scripted/stay", *TINY]


def test_a_fork_keeps_its_past_whatever_the_users_file_says(own: Write, tmp_path: Path):
    succeeds("model=scripted/random", *TINY, "output.dir=out", cwd=tmp_path)
    own("world: bar\nmodel: llama3.2\nprompt: json\n")
    (run,) = (tmp_path / "out" / "runs").iterdir()
    done = foundry("fork", str(run), "--at", "2", "output.dir=fork", "analyze=false", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    asked = yaml.safe_load((tmp_path / "fork" / "sweep.yaml").read_text())["asked"]
    assert asked[2:] == ["at=2", "output.dir=fork", "analyze=false"]


def config_of(done: subprocess.CompletedProcess[str]) -> dict[str, dict[str, Any]]:
    return {one["setting"]: one for one in msgspec.json.decode(done.stdout)["settings"]}


def test_config_says_where_each_setting_comes_from(own: Write, tmp_path: Path):
    file = own("runner.open_runs: 7\nmodel: llama3.2\n")
    argv = ("config", "world.steps=5", "runner.workers=3", "--json")
    done = foundry(*argv, cwd=tmp_path, OLLAMA_HOST="http://me:pw@gpu:1")
    found = {name: (one["value"], one["origin"]) for name, one in config_of(done).items()}
    assert found["runner.open_runs"] == (7, "user file") and found["world.steps"] == (5, "command line")
    assert found["model"] == ("llama3.2", "user file") and found["world"] == ("cafe_library", "default")
    assert found["model.server.hosts"] == ("http://***@gpu:1", "environment OLLAMA_HOST")
    assert found["model.server.keep_alive"] == ("30m", "default")
    whole = msgspec.json.decode(done.stdout)
    assert (whole["file"], whole["exists"]) == (str(file), True)
    assert "pw" not in done.stdout


def test_config_masks_keys(own: Write, tmp_path: Path):
    done = foundry("config", "model=scripted/stay", cwd=tmp_path, OPENAI_API_KEY="sk-very-secret")
    assert "sk-very-secret" not in done.stdout
    line = next(line for line in done.stdout.splitlines() if line.startswith("OPENAI_API_KEY"))
    assert line.split() == ["OPENAI_API_KEY", "***", "environment"]
    assert f"your own defaults: {user_config_file()} (not there)" in done.stdout


def test_config_shows_the_part_that_is_asked_for(own: Write, tmp_path: Path):
    done = foundry("config", "cache", "model.server.retry", "model=llama3.2", "--json", cwd=tmp_path)
    assert {name.rpartition(".")[0] for name in config_of(done)} == {"cache", "model.server.retry"}
    assert "Setting 'model.serve' not found." in refusal("config", "model.serve", cwd=tmp_path)


def test_config_shows_the_settings_that_decide_answers_apart(own: Write, tmp_path: Path):
    done = foundry("config", "world.steps", "cache", "model.server.hosts", "model.think", "format", cwd=tmp_path)
    first_words = [line.split("  ")[0] for line in done.stdout.splitlines()[:-1]]
    assert first_words == [
        "decides answers", "format", "world.steps", "model.think", "where and how", "cache.path", "model.server.hosts",
    ]  # fmt: skip
    think = next(line for line in done.stdout.splitlines() if line.startswith("model.think"))
    assert think.split()[:2] == ["model.think", "false"], "it shows a value as a command line takes it"


@pytest.mark.parametrize("argv", [("model=scripted/stay,scripted/random",), ("+sweep=first",)])
def test_config_shows_one_run_alone(argv: tuple[str, ...], own: Write, tmp_path: Path):
    refusal("config", *argv, cwd=tmp_path)
