"""The command that has a model label messages, against a real server."""

import pytest

from analysis.labelling import hand_labelled
from commands import cached_answers, foundry, succeeds
from foundry.labels.definition import label_named
from foundry.labels.folder import Judge, LabelFolder
from foundry.labels.judging import read_answer
from foundry.storing.store import SweepFolder
from ollama_cases import ChatCase
from ollama_server import OllamaServer
from walkers import WORLD, Habits, make_condition, write_sweep

WARNING = label_named("warning")
WARNINGS = {"fire1 near me", "火事だ、逃げて", "there is smoke"}


def kept_in(sweep: SweepFolder) -> Judge | None:
    judges = LabelFolder.of(sweep, "warning").judges()
    return judges[0] if judges else None


def answer(body) -> str:
    """Say yes to warnings, no to the rest, and something else to one text."""
    content = body["messages"][-1]["content"]
    message = content.split("-----\n")[1].strip()
    if message == "shall we meet in the cafe?":
        return "It depends."
    truth = {labelled.text: labelled.warning for labelled in hand_labelled()}
    return "Yes." if truth.get(message, message in WARNINGS) else "no"


def test_each_distinct_text_is_asked_about_once_and_its_label_kept_with_who_gave_it(make_sweep, tmp_path):
    sweep = make_sweep([make_condition("a", range(2))])
    with OllamaServer(answer) as server:
        command = ("label", str(sweep.path), "--model", "qwen3:4b", "model.options.num_predict=16")
        done = foundry(*command, cwd=tmp_path, OLLAMA_HOST=server.url)
        asked = len(server.bodies)
        again = foundry(*command, cwd=tmp_path, OLLAMA_HOST=server.url)
    assert (done.returncode, again.returncode) == (0, 0), done.stderr
    assert asked == len(server.bodies) == 5 + len(hand_labelled())
    options = server.bodies[0]["options"]
    assert (options["temperature"], options["num_predict"]) == (0.0, 16)
    assert len({options["seed"] for options in (body["options"] for body in server.bodies)}) == 1
    assert "fire1, blaze2" in next(
        body["messages"][0]["content"] for body in server.bodies if "there is smoke" in str(body)
    )
    kept = kept_in(sweep)
    assert (kept.labeller, kept.digest) == ("qwen3:4b", server.models["qwen3:4b"].digest)
    assert {judgement.text: judgement.label for judgement in kept.judgements} == {
        **dict.fromkeys(WARNINGS, "yes"), "hello": "no", "shall we meet in the cafe?": None,
    }  # fmt: skip
    assert "5 distinct texts labelled; for 1 of them the answer was unreadable" in done.stdout
    assert "precision 1.00 (65 of 65), recall 1.00 (65 of 65), Cohen's kappa 1.00 on 131 held-out texts" in done.stdout
    assert "upper bounds" in done.stdout


@pytest.mark.parametrize(
    ("model", "speak", "reason"),
    [
        ("scripted/avoid", 0.4, "cannot label texts"),
        ("absent:1b", 0.4, "absent:1b"),
        ("qwen3:4b", 0, "nothing to label"),
    ],
)
def test_a_model_that_cannot_label_and_a_sweep_in_which_nothing_was_said_are_refused_in_one_line(
    make_sweep, tmp_path, model, speak, reason
):
    sweep = make_sweep([make_condition("a", [0])], {"a": Habits(speak=speak)})
    with OllamaServer(answer) as server:
        done = foundry("label", str(sweep.path), "--model", model, cwd=tmp_path, OLLAMA_HOST=server.url)
    assert (done.returncode, kept_in(sweep)) == (2, None)
    assert reason in done.stderr


def test_a_model_none_of_whose_answers_says_yes_or_no_fails_and_earlier_labels_stay(make_sweep, tmp_path):
    sweep = make_sweep([make_condition("a", [0])])
    earlier = Judge(labeller="m", digest=None, question_sha256="", parameters={}, judgements=())
    LabelFolder.of(sweep, "warning").keep_judge(earlier)
    with OllamaServer(lambda body: "It depends.") as server:
        done = foundry("label", str(sweep.path), "--model", "llama3.2", cwd=tmp_path, OLLAMA_HOST=server.url)
    assert (done.returncode, done.stdout) == (3, "")
    assert "answered neither yes nor no to any of 5 texts; its first answer begins 'It depends.'" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1 and kept_in(sweep) == earlier


def test_what_was_answered_before_a_failure_is_not_asked_again(tmp_path):
    sweep = write_sweep(tmp_path / "sweep", [make_condition("a", [0])])
    broken = True

    def faltering(body):
        if broken and "there is smoke" in body["messages"][-1]["content"]:
            return ChatCase(status=400, error="this text is refused")
        return answer(body)

    command = ("label", str(sweep.path), "--model", "qwen3:4b")
    with OllamaServer(faltering) as server:
        failed = foundry(*command, cwd=tmp_path, OLLAMA_HOST=server.url)
        assert (failed.returncode, kept_in(sweep)) == (3, None), failed.stderr
        before, broken = len(server.bodies), False
        succeeds(*command, cwd=tmp_path, OLLAMA_HOST=server.url)
        assert len(server.bodies) == before + 1


def test_the_messages_of_baselines_are_labelled_too_and_each_once(tmp_path):
    sweep = write_sweep(tmp_path / "sweep", [make_condition("a", range(2))])
    other = {**WORLD, "fires": WORLD["fires"][:1]}
    write_sweep(sweep.baselines_dir, [make_condition("walker", [0]), make_condition("walker", [1], world=other)])
    with OllamaServer(answer) as server:
        command = ("label", str(sweep.path), "--model", "qwen3:4b")
        succeeds(*command, cwd=tmp_path, OLLAMA_HOST=server.url)
    kept = kept_in(sweep)
    texts = [(judgement.text, tuple(judgement.context["fires"])) for judgement in kept.judgements]
    assert len(texts) == len(set(texts))
    assert {fires for _, fires in texts} == {("fire1", "blaze2"), ("fire1",)}


@pytest.mark.parametrize(
    ("reply", "expected"),
    [
        ("yes", "yes"), ("No.", "no"), (" **YES** \n", "yes"), ('"no"', "no"), ("<think>fire?</think>yes", "yes"),
        ("yes, because it burns", None), ("", None), ("maybe", None), ("yes no", None), ("Yesterday", None),
    ],
)  # fmt: skip
def test_only_a_bare_yes_or_no_is_an_answer(reply, expected):
    assert read_answer(reply, ("yes", "no")) == expected


def test_labels_of_a_model_that_is_replaced_meanwhile_are_not_kept(tmp_path):
    sweep = write_sweep(tmp_path / "sweep", [make_condition("a", range(2))])
    with OllamaServer(answer) as server:
        model = server.models["qwen3:4b"]

        def replace(number: int, body: object) -> None:
            model.digest = "ff" * 32 if number == 9 else model.digest

        server.on_chat = replace
        done = foundry("label", str(sweep.path), "--model", "qwen3:4b", cwd=tmp_path, OLLAMA_HOST=server.url)
    assert (
        done.returncode == 3
        and "changed while it labelled (digest d4d4d4d4d4d4 at the start" in done.stderr
        and "Traceback" not in done.stderr
    )
    assert "no label was written" in done.stderr and kept_in(sweep) is None
    assert cached_answers(tmp_path / "outputs" / "answers.sqlite") < 9
