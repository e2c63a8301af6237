"""Templates can say what an agent may know, and nothing more; scripted policies are told the rest."""

from __future__ import annotations

import re

import pytest

from episodes import ROOM, composed
from foundry.cli import run
from foundry.composing.preflight import first_questions, scenario_of
from foundry.errors import InputError
from foundry.prompts.prompt import Prompt
from foundry.worlds.base import Question

SECRET = {"way", "near", "reached", "target_yaw", "target_pitch", "in_view", "stopped"}


@pytest.fixture(scope="module")
def question() -> Question:
    settings = (f"scene={ROOM}", "world.targets=[{name: north, prims: [/Room/North], radius: 0.5}]")
    (asked,) = first_questions(scenario_of(composed("usd", "stay", *settings).conditions[0].config), seed=0)
    return asked


@pytest.mark.slow
def test_scripted_policies_are_told_what_the_observation_does_not_hold(question: Question):
    assert set(question.secret) == SECRET
    assert set(question.told) == SECRET | set(question.observation)
    assert SECRET.isdisjoint(question.observation)
    assert len(question.told["way"]) > 0 and question.told["near"] is False and 0 <= question.told["target_yaw"] < 360


@pytest.mark.parametrize("name", [*sorted(SECRET), "ways", "nea", "reache", "target_yav"])
@pytest.mark.parametrize("template", ["{{{{ {} }}}}", "{{% if {} %}}x{{% endif %}}", "{{{{ self.{} }}}}"])
def test_a_template_that_names_a_secret_or_nearly_does_names_nothing(name: str, template: str, question: Question):
    with pytest.raises(InputError) as refusal:
        Prompt("mine", {"move": template.format(name)}).render(question)
    message = str(refusal.value)
    assert f"no attribute '{name}'" in message or f"'{name}' is undefined" in message
    offered = message.partition("Observed:")[2] or message.partition("Did you mean")[2]
    assert SECRET.isdisjoint(re.findall(r"\w+", offered))


@pytest.mark.slow
def test_the_oracle_without_a_target_is_refused_before_the_start(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for models in ("scripted/oracle", "scripted/stay,scripted/oracle"):
        assert run(["-m", "world=usd", "scene=office.usdz", f"model={models}", "world.steps=1", "output.dir=out"]) == 2
        err = capsys.readouterr().err
        assert "'scripted/oracle' goes to a target, and the world has none" in err and err.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_world_without_targets_says_that_nothing_can_be_reached(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    arguments = ["scene=office.usdz", "model=scripted/spin", "world.steps=1", "analyze=false", "runner.workers=1"]
    assert run(["world=usd", *arguments, "output.dir=out"]) == 0
    assert "World 'usd' has no world.targets" in capsys.readouterr().out
    assert run(["world=office", "model=scripted/spin", *arguments[2:], "output.dir=with"]) == 0
    assert "world.targets" not in capsys.readouterr().out
