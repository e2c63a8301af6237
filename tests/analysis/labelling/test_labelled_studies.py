"""A whole study with known truth: played into a folder, drawn by the command, labelled in journals, and analysed."""

from pathlib import Path

import labelled_studies
import pytest

from foundry.labels.folder import LabelFolder
from foundry.storing.store import SweepFolder


@pytest.mark.slow
def test_a_study_with_known_truth_is_misread_by_the_rule_and_corrected_from_its_own_folder(tmp_path: Path):
    found = labelled_studies.study(tmp_path, 0, {"a": 0.4, "b": 0.4}, 100)
    assert found["rule"][2] < 0, "the rule claims a difference that does not exist"
    assert found["corrected"][1] < 0 < found["corrected"][2]
    folder = LabelFolder.of(SweepFolder.open(tmp_path / "study"), "warning")
    sample = folder.sample()
    assert len(folder.labels_by("ana")) == len(sample.drawn) == 200
    assert "unclear" in folder.labels_by("ben").values()
    texts = {one.item: one.text for one in sample.drawn}
    warnings = [texts[item] for item, label in folder.labels_by("ana").items() if label == "yes"]
    assert {text.split()[0] for text in warnings} == {"Fire", "It"}
