"""Methods and references of an analysis: what is said is what was done."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from analysis import analyze
from analysis.paper.methods import bibtex, methods
from analysis.report.material import Material, gather
from foundry.storing.store import SweepFolder

SERVED = {"server": {"hosts": "http://a"}, "options": {"temperature": 0.2, "top_k": 40, "stop": None}, "think": False}


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory, write_sweep: Callable[..., SweepFolder], make_condition: Any):
    """Two models over six seeds, one of them served."""
    conditions = [make_condition(name, range(6)) for name in ("scripted/stay", "qwen3:4b")]
    conditions[1].config["model"].update(SERVED)
    idle = SimpleNamespace(speak=0.4, move=0.3, unreadable=0.1, texts=("hello", "fire"))
    return write_sweep(tmp_path_factory.mktemp("methods") / "sweep", conditions, {"scripted/stay": idle})


@pytest.fixture(scope="module")
def made(served: SweepFolder) -> Material:
    return gather([served.path])


def keys(text: str) -> list[str]:
    return re.findall(r"^@\w+\{(.*),$", text, re.MULTILINE)


@pytest.mark.slow
def test_sampling_is_told_of_served_models_alone(made: Material):
    design = methods(made.basis)[0]
    assert " qwen3:4b was asked with temperature 0.2, top_k 40, think false." in design
    assert design.count("asked with") == 1


def test_what_is_left_out_is_told(served: SweepFolder):
    design = methods(gather([served.path], without=["model=scripted/stay"]).basis)[0]
    assert "Of all runs a part alone was taken: without model=scripted/stay: 6 of 12 runs." in design


def test_references_are_those_of_what_was_used(made: Material, served: SweepFolder):
    found = keys(bibtex(made.basis))
    assert found[:2] == ["foundry", "model-qwen3-4b"]
    assert {"fisher1935", "holm1979"} <= set(found)
    assert not {"lan1983", "gaffke2005", "ashery2025"} & set(found)
    margin = gather([served.path], family=["idle_rate.chosen"], margins={"idle_rate.chosen": 0.5})
    assert "gaffke2005" in keys(bibtex(margin.basis))


def test_one_group_has_no_reference_of_a_test(served: SweepFolder):
    alone = gather([served.path], only=["model=qwen3:4b"])
    assert not {"fisher1935", "holm1979"} & set(keys(bibtex(alone.basis)))


def test_every_brace_of_the_references_is_closed(made: Material):
    text = bibtex(made.basis)
    assert text.count("{") == text.count("}")


def test_an_analysis_writes_summary_methods_and_references(served: SweepFolder):
    found = analyze([served.path], plots=False)
    assert {"summary.md", "methods.md", "references.bib"} <= {file.name for file in found.written}
    assert "qwen3:4b was asked with" in (found.path / "methods.md").read_text(encoding="utf-8").replace("\\", "")
    assert all(isinstance(file, Path) and file.exists() for file in found.written)
