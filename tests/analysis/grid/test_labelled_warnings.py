"""Warnings by other labels than the rule's, and against chance."""

import dataclasses
import math

import numpy as np
import pytest

from analysis.grid.signatures import warning
from walkers import Habits

RULE = {"fire1 near me": True, "火事だ、逃げて": True, "there is smoke": True, "hello": False}
RULE["shall we meet in the cafe?"] = False


def same(found: dict[str, float], expected: dict[str, float]) -> bool:
    return found == pytest.approx(expected, nan_ok=True)


def test_labels_decide_what_is_a_warning_and_the_rules_change_nothing(recorded):
    run = recorded(seed=3).run
    assert same(warning.measure(dataclasses.replace(run, labels=RULE)), warning.measure(run))
    none = warning.measure(dataclasses.replace(run, labels=dict.fromkeys(RULE, False)))
    assert (none["n_warnings"], none["social_reach"], none["warning_share"]) == (0, 0, 0)
    every = warning.measure(dataclasses.replace(run, labels=dict.fromkeys(RULE, True)))
    assert (every["n_warnings"], every["warning_share"]) == (every["n_messages"], 1)


def test_a_text_without_a_label_is_never_taken_for_harmless(recorded):
    run = recorded(seed=3).run
    unknown = {text: label for text, label in RULE.items() if text != "there is smoke"}
    measures = warning.measure(dataclasses.replace(run, labels=unknown))
    low = warning.measure(dataclasses.replace(run, labels=unknown | {"there is smoke": False}))
    high = warning.measure(dataclasses.replace(run, labels=RULE))
    assert measures["n_unlabelled"] == sum(text == "there is smoke" for text in run.said.ravel()) > 0
    assert measures["n_messages"] == high["n_messages"]
    about_reach = {"social_reach", "traced_reach", "relay_probability", "reproduction", "depth", "rmst", "n_told"}
    changed = {name for name in about_reach if low[name] != high[name]}
    assert changed
    assert {name for name in about_reach if math.isnan(measures[name])} == changed
    assert measures["oracle_reach"] == high["oracle_reach"]
    labelled = [text for text in run.said[run.spoke] if text != "there is smoke"]
    assert measures["warning_share"] == pytest.approx(sum(RULE[text] for text in labelled) / len(labelled))


def test_who_warns_because_it_was_warned_relays_above_chance(recorded):
    run = recorded(seed=2, habits=Habits(speak=0.6, unreadable=0), steps=60, agents=12).run
    said, knows = run.said.copy(), np.zeros(run.agents, dtype=bool)
    for step in range(run.steps):
        knows |= run.perceived[step]
        warns = knows & run.spoke[step]
        said[step] = np.where(run.spoke[step], np.where(warns, "fire!", "hello"), None)
        heard = run.deliveries[run.deliveries[:, 0] == step + 1]
        knows[heard[warns[heard[:, 1]], 2]] = True
    measures = warning.measure(dataclasses.replace(run, said=said))
    assert measures["relay_above_chance"] > 0.05
    assert measures["false_alarm_rate"] == 0
