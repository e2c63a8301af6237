"""The command line as a user meets it."""

import shutil
import sys
from pathlib import Path

import msgspec
import pytest
import yaml
from typer.main import get_command

from commands import foundry, refusal, statuses, succeeds, sweep_folder
from foundry import seeding
from foundry.cli import RENAMED, run
from foundry.commands.application import app
from foundry.storing.store import SweepFolder
from ollama_cases import BAD_OPTION, Body, ChatCase, grid_answer, refused
from ollama_server import OllamaServer

TINY = ("world.agents=3", "world.steps=2", "analyze=false", "runner.workers=1")


def complain(capsys: pytest.CaptureFixture[str], *argv: str) -> str:
    """Run a command line that cannot work; return its one line on the standard error."""
    assert run(argv) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and error.startswith("foundry: "), error
    return error


@pytest.mark.parametrize(("old", "new"), RENAMED.items())
def test_an_old_command_names_the_new_one(old: str, new: str, capsys: pytest.CaptureFixture[str]):
    assert complain(capsys, *old.split(), "x") == f"foundry: 'foundry {old}' is now: foundry {new}\n"


def refused_by(command: str) -> tuple[list[str], str]:
    """Return what a command does not take, and what it says of it: too little, an unknown option, or no folder."""
    found = get_command(app).commands[command]  # type: ignore[attr-defined]
    if any(param.required for param in found.params):
        return [command], "foundry: Missing argument "
    if found.context_settings:
        return [command, "--config-dir", "nowhere"], "folder not found"
    return [command, "--no-such-option"], "foundry: No such option: --no-such-option"


@pytest.mark.parametrize("command", get_command(app).commands)  # type: ignore[attr-defined]
def test_every_command_says_what_it_lacks_or_does_not_take_in_one_line(
    command: str, capsys: pytest.CaptureFixture[str]
):
    argv, said = refused_by(command)
    told = complain(capsys, *argv)
    assert said in told
    if "nowhere" not in argv:
        assert f"Usage: foundry {command} [OPTIONS]" in told and f"for more, use foundry {command} --help." in told


def test_the_help_says_the_whole_sentence_about_each_command(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("COLUMNS", "80")
    assert run(["--help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "after how many seeds." in " ".join(" ".join(lines).split())
    assert not any(line.endswith("...") for line in lines[1:]) and max(map(len, lines)) <= 80


@pytest.mark.parametrize(
    ("argv", "expected"),
    [
        ("world=cafe_libary", "Did you mean 'cafe_library'"),
        ("model=scripted/randam", "Did you mean 'scripted/random'"),
        ("model=scripted/random world.stepz=3", "Did you mean 'world.steps'"),
        ("+sweep=cros_model", "Did you mean 'cross_model'"),
        ("analyse x", "Did you mean 'analyze'"),
        ("seed=0-9", "Add -m, as in: foundry -m seed=0-9"),
        ("sampling_seed=1,2", "Add -m"),
        ("model=scripted/random seed=-1", "seed=-1 is not a seed"),
        ("-m model=scripted/random seed=9-2", "write seed=2-9"),
        ("-m model=scripted/random runner.workers=1,2", "'runner.workers' cannot have several values"),
        ("model=scripted/random world.steps=many", "world.steps"),
        ("model=scripted/random world.agents=-3", "world.agents"),
        ("model=scripted/random record.frames=often", "a number of steps; got often"),
        ("model=scripted/random seed==1=", "'seed==1=' cannot be read"),
        ("resume nowhere", "'nowhere' does not exist"),
        ("status .", "is not a sweep's folder"),
        ("check --known bat", "Did you mean 'bar'"),
        ("check world=bar --write page.md", "Add --known"),
        ("status s3://bucket/x", "foundry status s3://bucket/x --fetch DIR"),
        ("plan --prompt model=scripted/random --kind song", "Its kinds: message, action"),
        ("plan --prompt model=scripted/random --agent 99", "agents 0 to 19"),
        ("plan --prompt world=fishery model=scripted/random --step 2", "agents 0 to 4 and steps 1 to 1"),
        ("plan model=scripted/random --agent 0", "--agent only works with --prompt"),
        ("plan model=scripted/random --difference 0.1", "--difference only works with --pilot DIR"),
        ("doctor model=scripted/random --pull llama3.2", "Leave out model="),
        ("-m model=scripted/stay --json", "Unknown option '--json'. The command with --help lists"),
        ("--cfg jop model=scripted/stay", "--cfg/-c: invalid choice: 'jop' (choose from "),
        ("hydra.searchpath=x model=scripted/stay", "hydra.searchpath must be a list; got 'x'"),
        ("world.personas={state:{calm:1}}", "'world.personas.state' not found. Did you mean 'world.personas.gender'?"),
        (
            "model=scripted/random +model.stay_probabilty=1",
            "foundry: 'scripted/random' (foundry.worlds.any.any_policies.Random): setting 'stay_probabilty' not found. "
            "Did you mean 'stay_probability'? Available: name, stay_probability. Correct the setting, or leave it out.",
        ),
        ("model=qwen3:4b +model.temperature=1", "Did you mean 'options.temperature'? Available: format, logprobs, "),
        ("world=bar model=scripted/random +world.capcity=1", "setting 'capcity' not found. Did you mean 'capacity'?"),
        ("plan outputs/pilot", "'outputs/pilot' is a folder. To write into it, use output.dir=outputs/pilot"),
        (
            "-m seed=0,1 hydra/sweeper=optuna",
            "'hydra/sweeper' is a setting of Hydra that foundry does not use. It uses:",
        ),
        ("plan -m seed=0,1 hydra.sweep.dir=mine", "Write a sweep as -m key=a,b and its folder as output.dir=DIR."),
        ("++hydra.launchers=1", "'hydra.launchers' is a setting of Hydra that"),
    ],
)
def test_bad_input_gets_one_line_that_says_how_to_go_on(
    argv: str, expected: str, workspace: Path, capsys: pytest.CaptureFixture[str]
):
    Path("outputs/pilot").mkdir(parents=True)
    assert expected in complain(capsys, *argv.split())
    assert [entry for entry in workspace.rglob("run.json")] == []


def test_a_folder_of_many_sweeps_is_refused_with_some_of_their_names(
    workspace: Path, capsys: pytest.CaptureFixture[str]
):
    for number in range(12):
        (workspace / "outputs" / f"sweep{number:02}").mkdir(parents=True)
        (workspace / "outputs" / f"sweep{number:02}" / "sweep.yaml").touch()
    assert complain(capsys, "status", "outputs").endswith(" sweep08, sweep09 and 2 more.\n")


def test_without_a_server_foundry_alone_says_how_to_go_on(
    workspace: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("OLLAMA_HOST", "http://127.0.0.1:9")
    line = complain(capsys)
    assert "ollama serve" in line and "model=scripted/random" in line
    assert list(workspace.iterdir()) == []


def test_a_folder_that_cannot_be_written_or_holds_other_files_is_left_alone(
    workspace: Path, capsys: pytest.CaptureFixture[str]
):
    (workspace / "file").write_text("in the way")
    assert "cannot be written to" in complain(capsys, "model=scripted/stay", "output.dir=file/sweep")
    (workspace / "mine").mkdir()
    (workspace / "mine" / "thesis.tex").write_text("precious")
    assert "files that are not a sweep" in complain(capsys, "model=scripted/stay", "output.dir=mine")


@pytest.mark.slow
def test_any_tag_is_a_model_that_is_loaded_once_and_freed_before_the_next_and_ranges_of_seeds_expand(workspace: Path):
    models = ("qwen3:4b", "llama3.2")
    argv = ["-m", f"model={','.join(models)}", "seed=0-1,5", *TINY]
    with OllamaServer() as server:
        done = succeeds(*argv, cwd=workspace, OLLAMA_HOST=server.url)
    folder = SweepFolder.open(workspace / sweep_folder(done.stdout))
    assert {(run.config()["model"]["name"], run.factors["model"], run.run.seed) for run in folder.runs()} == {
        (model, model, seed) for model in models for seed in (0, 1, 5)
    }
    assert len(folder.runs()) == 6 and (folder.path / "multirun.yaml").exists()
    asked = [body["model"] for body in server.bodies]
    assert asked == sorted(asked, reverse=True) and set(asked) == set(models)
    assert [(load["model"], load["keep_alive"]) for load in server.loads] == [
        ("qwen3:4b", "30m"), ("qwen3:4b", 0), ("llama3.2", "30m"),
    ]  # fmt: skip


def test_tags_of_other_registries_and_hydras_own_flags_work(workspace: Path, capsys: pytest.CaptureFixture[str]):
    assert run(["model=hf.co/someone/some-model:Q4_K_M", "--cfg", "job"]) == 0
    assert yaml.safe_load(capsys.readouterr().out)["model"]["name"] == "hf.co/someone/some-model:Q4_K_M"
    assert run(["model=scripted/stay", "world.steps=3", "--cfg", "job", "--package", "world"]) == 0
    assert "steps: 3" in capsys.readouterr().out
    assert list(workspace.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper_2d", "cross_model", "prompt_sensitivity", "first"])
def test_every_shipped_sweep_composes(name: str, workspace: Path):
    from foundry.composing.compose import compose

    composed = compose([f"+sweep={name}"])
    assert sum(len(condition.seeds) for condition in composed.conditions) >= 9


@pytest.fixture
def without_gym(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("gymnasium", "pettingzoo", "minigrid"):
        monkeypatch.setitem(sys.modules, name, None)


@pytest.mark.slow
@pytest.mark.usefixtures("without_gym")
def test_a_named_sweep_leaves_out_worlds_whose_package_is_missing_and_one_that_is_named_itself_is_refused(
    workspace: Path, capsys: pytest.CaptureFixture[str]
):
    assert run(["plan", "+sweep=validation", "model=scripted/random", "seed=0", "world.steps=1"]) == 0
    told = capsys.readouterr()
    assert "7 runs, 0 complete" in told.out
    assert told.err == (
        "Left out, since a package is missing: frozen_lake, cliff_walking, tictactoe. The shipped worlds need the "
        "extra `gym`. From a clone: pip install -e '.[gym]'\n"
    )
    for world in ("frozen_lake,bar", "minigrid", "tictactoe"):
        assert run(["+sweep=validation", f"world={world}", "model=scripted/random", "seed=0"]) == 2
        refusal = capsys.readouterr().err
        assert refusal.endswith("pip install -e '.[gym]'\n") and refusal.count("\n") == 1


def test_a_sampling_seed_varies_the_sampling_and_leaves_the_world_alone(workspace: Path):
    argv = ["-m", "model=scripted/random", "seed=5", "sampling_seed=0-1", "output.dir=out", *TINY]
    assert run(argv) == 0
    first, second = SweepFolder.open("out").runs()
    starts = [
        [
            (line["x"], line["y"])
            for line in map(msgspec.json.decode, run.steps_bytes().splitlines())
            if line["step"] == 1
        ]
        for run in (first, second)
    ]
    assert starts[0] == starts[1]
    assert first.steps_bytes() != second.steps_bytes()


def test_a_run_that_fails_is_recorded_and_the_others_go_on_and_another_server_can_end_it(workspace: Path):
    unlucky_seed = seeding.sampling_seed(1, step=2, agent=2, kind="action")

    def answer(body: Body) -> str | ChatCase:
        unlucky = body["options"]["seed"] == unlucky_seed
        return refused(400, "this prompt is too much") if unlucky else grid_answer(body)

    argv = ["-m", "model=qwen3:4b", "seed=0-2", "output.dir=out", *TINY]
    with OllamaServer(answer) as server:
        done = foundry(*argv, cwd=workspace, OLLAMA_HOST=server.url)
    assert done.returncode == 3
    assert "this prompt is too much" in done.stdout and "foundry resume out" in done.stdout
    assert statuses(workspace / "out") == ["complete", "failed", "complete"]
    with OllamaServer() as other:
        again = foundry("resume", "out", cwd=workspace, OLLAMA_HOST=other.url)
    assert again.returncode == 0, again.stderr
    assert statuses(workspace / "out") == ["complete"] * 3
    assert set(server.answered.values()) == {1} and other.bodies
    assert not server.answered.keys() & other.answered.keys()


def test_an_error_that_no_call_can_escape_ends_the_sweep(workspace: Path):
    argv = ["-m", "model=qwen3:4b", "seed=0-2", "output.dir=out", "runner.open_runs=1", *TINY]
    with OllamaServer(lambda body: BAD_OPTION) as server:
        done = foundry(*argv, cwd=workspace, OLLAMA_HOST=server.url)
    assert done.returncode == 3
    assert 'option "seed" must be of type integer' in done.stderr
    assert statuses(workspace / "out") == ["failed", None, None]


def test_plan_counts_what_would_be_sent_and_changes_nothing(workspace: Path):
    argv = ["-m", "model=qwen3:4b", "output.dir=out", *TINY]
    with OllamaServer() as server:
        succeeds(*argv, "seed=0", cwd=workspace, OLLAMA_HOST=server.url)
        paid = len(server.bodies)
        planned = foundry("plan", *argv[:2], "seed=0-2", *TINY, cwd=workspace, OLLAMA_HOST=server.url)
        continued = foundry("plan", *argv, "seed=0", cwd=workspace, OLLAMA_HOST=server.url)
        assert len(server.bodies) == paid
    assert "3 runs, 0 complete; at most 24 calls would be sent" in planned.stdout
    assert "1 run, 1 complete; at most 0 calls would be sent" in continued.stdout
    assert not list((workspace / "outputs").glob("2*"))


def test_prompt_prints_what_a_run_really_sends_and_that_of_a_game(workspace: Path, capsys: pytest.CaptureFixture[str]):
    overrides = ["model=scripted/avoid", "seed=4", "world.agents=5", "world.steps=4"]
    assert run([*overrides, "output.dir=out", *TINY[2:]]) == 0
    capsys.readouterr()
    assert run(["plan", "--prompt", *overrides, "--step", "3", "--agent", "2", "--kind", "action"]) == 0
    (only,) = SweepFolder.open("out").runs()
    sent = next(call for call in only.calls() if (call.step, call.agent, call.kind) == (3, 2, "action"))
    assert capsys.readouterr().out == sent.messages[0]["content"] + "\n"
    assert run(["plan", "--prompt", "world=bar", "model=scripted/random"]) == 0
    assert '"go" or "stay"' in capsys.readouterr().out


def test_prompt_needs_no_server(workspace: Path):
    done = succeeds("plan", "--prompt", "--step", "1", "--agent", "3", cwd=workspace, OLLAMA_HOST="http://127.0.0.1:9")
    assert done.stdout.startswith("You are Agent 3 (") and done.stdout.endswith("Step: 1\n")
    assert "in this prompt, each of them counts as silence" in done.stderr


def test_doctor_lists_what_servers_have_heeds_no_proxy_and_refuses_a_bad_address(workspace: Path):
    unusable = {"ALL_PROXY": "socks9://127.0.0.1:9", "SSL_CERT_FILE": str(workspace / "absent.pem")}
    with OllamaServer() as server:
        done = foundry("doctor", "model=llama3.2", "--no-calls", cwd=workspace, OLLAMA_HOST=server.url, **unusable)
    assert done.returncode == 0, done.stderr
    assert "qwen2.5vl:3b" in done.stdout and "vision" in done.stdout and "c3c3c3c3c3c3" in done.stdout
    line = refusal("doctor", cwd=workspace, OLLAMA_HOST="gpu1:port")
    assert line.startswith("foundry: Ollama host 'gpu1:port' cannot be read")


def test_doctor_fetches_a_model_that_is_missing_and_says_where_it_cannot(workspace: Path):
    with OllamaServer() as server:
        done = foundry("doctor", "--pull", "gemma3:4b", cwd=workspace, OLLAMA_HOST=server.url)
        failed = foundry("doctor", "--pull", "gemma4:4b", cwd=workspace, OLLAMA_HOST=server.url)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("pulling manifest\npulling a1a1\nsuccess\n") and "gemma3:4b" in done.stdout
    assert failed.returncode == 2 and "file does not exist" in failed.stderr
    with OllamaServer() as server:
        server.offline = True
        failed = foundry("doctor", "--pull", "gemma3:4b", cwd=workspace, OLLAMA_HOST=server.url)
    assert failed.returncode == 2
    assert f"'gemma3:4b' was not downloaded. Ollama at {server.url} answers: pull model manifest" in failed.stderr
    assert "no such host. The server downloads the model" in failed.stderr
    assert "ollama serve" not in failed.stderr and failed.stderr.count("\n") == 1


def test_every_second_picture_of_a_run_is_kept_and_its_configuration(workspace: Path):
    assert run(["model=scripted/avoid", "output.dir=out", *TINY, "world.steps=3", "record.frames=2"]) == 0
    (only,) = SweepFolder.open("out").runs()
    assert only.pictures() == ["frames/step_0000.png", "frames/step_0002.png"]
    assert yaml.safe_load((only.path / "config.yaml").read_text()) == only.config()


def test_a_file_where_a_run_should_be_is_named(workspace: Path, capsys: pytest.CaptureFixture[str]):
    assert run(["model=scripted/avoid", *TINY, "output.dir=s"]) == 0
    lost = SweepFolder.open("s").runs()[0].path
    shutil.rmtree(lost)
    lost.write_text("in the way", encoding="utf-8")
    for command in ("analyze", "resume", "status"):
        assert f"{lost}" in complain(capsys, command, "s")
