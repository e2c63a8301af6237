"""Templates become messages, and say what an agent may know and nothing more; scripted policies are told the rest."""

import re

import pytest

from episodes import ROOM, composed
from foundry.cli import run
from foundry.composing.preflight import first_questions, scenario_of
from foundry.errors import InputError
from foundry.prompts.prompt import Prompt
from foundry.worlds.base import Question

SECRET = {"way", "near", "reached", "target_yaw", "target_pitch", "in_view", "stopped"}


def ask(kind="message", images=(), **observation):
    return Question(1, 0, kind, observation, images)


def test_one_text_is_one_user_message_without_its_last_line_break():
    (message,) = Prompt("p", {"message": "I am {{ agent }}.\n"}).render(ask(agent=3))
    assert (message.role, message.content) == ("user", "I am 3.")


def test_a_list_gives_one_message_each_and_images_go_to_the_last_user_message():
    template = [
        {"role": "system", "content": "You act."},
        {"role": "user", "content": "Look."},
        {"role": "assistant", "content": "Yes."},
        {"role": "user", "content": "Now {{ x }}."},
        {"role": "assistant", "content": "I"},
    ]
    messages = Prompt("p", {"message": template}).render(ask(images=(b"png",), x=1))
    assert [message.images for message in messages] == [(), (), (), (b"png",), ()]
    assert [message.content for message in messages] == ["You act.", "Look.", "Yes.", "Now 1.", "I"]


def test_text_from_models_is_never_template_code_and_a_key_named_like_a_method_is_the_key():
    prompt = Prompt("p", {"message": "{{ heard }} {% for text in texts %}{{ text }}{% endfor %}"})
    code = "{{ 7 * 7 }}{% raise %}{# <b>&"
    assert prompt.render(ask(heard=code, texts=[code]))[0].content == f"{code} {code}"
    prompt = Prompt("p", {"message": "{{ persona.items }} {{ persona['keys'] }}"})
    assert prompt.render(ask(persona={"items": "a", "keys": "b"}))[0].content == "a b"


@pytest.mark.parametrize(
    ("template", "says"),
    [
        ("one\n{{ agnet }}", "Prompt 'p', template 'message', line 2: 'agnet' is undefined. Did you mean 'agent'?"),
        ("{{ fires[0].radus }}", "line 1: 'dict object' has no attribute 'radus'. Did you mean 'radius'?"),
        ("{{ zzz }}", "Observed: agent, fires."),
        ("{{ agent.__class__.__mro__ }}", "line 1: access to attribute '__class__'"),
        ("{{ agent + 'x' }}", "line 1: unsupported operand"),
        ("{{ fires.append(1) }}", "line 1"),
    ],
)  # fmt: skip
def test_a_template_that_cannot_be_filled_names_variant_kind_line_and_name(template, says):
    prompt = Prompt("p", {"message": template})
    with pytest.raises(InputError) as caught:
        prompt.render(ask(agent=1, fires=[{"radius": 3}]))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("templates", "says"),
    [
        ({"action": "one\n{% if %}"}, "Prompt 'p', template 'action', line 2: "),
        ({"action": "{{ x | nosuch }}"}, "No filter named 'nosuch'"),
        ({"action": 3}, "use a text, or a list"),
        ({"action": []}, "use a text, or a list"),
        ({"action": ["text"]}, "needs `role` and `content`"),
        ({"action": [{"role": "user", "text": "t"}]}, "needs `role` and `content`"),
        ({"action": [{"role": "usr", "content": "t"}]}, "'usr' not found. Did you mean 'user'?"),
        ({"action": [{"role": "system", "content": "t"}]}, "at least one message needs the role 'user'"),
    ],
)
def test_a_broken_template_is_refused_when_it_is_loaded(templates, says):
    with pytest.raises(InputError) as caught:
        Prompt("p", templates)
    assert says in str(caught.value)


def test_a_missing_kind_lists_those_there_are():
    prompt = Prompt("p", {"message": "m", "action": "a"})
    with pytest.raises(InputError, match="'act' not found. Did you mean 'action'.* Available: action, message"):
        prompt.render(ask(kind="act"))
    assert prompt.kinds == ("message", "action")


@pytest.mark.slow
def test_scripted_policies_are_told_what_the_observation_does_not_hold():
    settings = (f"scene={ROOM}", "world.targets=[{name: north, prims: [/Room/North], radius: 0.5}]")
    (question,) = first_questions(scenario_of(composed("usd", "stay", *settings).conditions[0].config), seed=0)
    assert set(question.secret) == SECRET
    assert set(question.told) == SECRET | set(question.observation)
    assert SECRET.isdisjoint(question.observation)
    assert len(question.told["way"]) > 0 and question.told["near"] is False and 0 <= question.told["target_yaw"] < 360


@pytest.mark.parametrize("name", [*sorted(SECRET), "ways", "nea", "reache", "target_yav"])
@pytest.mark.parametrize("template", ["{{{{ {} }}}}", "{{% if {} %}}x{{% endif %}}", "{{{{ self.{} }}}}"])
def test_a_template_that_names_a_secret_or_nearly_does_names_nothing(name: str, template: str):
    asked = Question(1, 0, "move", {"x": 1.0, "task": "Look"}, secret=dict.fromkeys(SECRET, 1))
    with pytest.raises(InputError) as refusal:
        Prompt("mine", {"move": template.format(name)}).render(asked)
    message = str(refusal.value)
    assert f"no attribute '{name}'" in message or f"'{name}' is undefined" in message
    offered = message.partition("Observed:")[2] or message.partition("Did you mean")[2]
    assert SECRET.isdisjoint(re.findall(r"\w+", offered))


@pytest.mark.slow
def test_the_oracle_without_a_target_is_refused_before_the_start(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    models = "model=scripted/stay,scripted/oracle"
    assert run(["-m", "world=usd", "scene=office.usdz", models, "world.steps=1", "output.dir=out"]) == 2
    err = capsys.readouterr().err
    assert "'scripted/oracle' goes to a target, but the world has none" in err and err.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_world_without_targets_says_that_nothing_can_be_reached(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    arguments = ["scene=office.usdz", "model=scripted/spin", "world.steps=1", "analyze=false", "runner.workers=1"]
    assert run(["world=usd", *arguments, "output.dir=out"]) == 0
    assert "World 'usd' has no world.targets" in capsys.readouterr().out
    assert run(["world=office", "model=scripted/spin", *arguments[2:], "output.dir=with"]) == 0
    assert "world.targets" not in capsys.readouterr().out
