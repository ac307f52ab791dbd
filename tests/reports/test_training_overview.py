"""What a training run scored: shares as shares, the clips without direction in per cent."""

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.tables import training_overview

TASK = {
    "clips": 30,
    "generated": 0.9,
    "generated_held_out_wordings": 0.8,
    "probe": 0.7,
    "global_probe": 0.6,
}
NUMBERS = {
    "rotation": TASK,
    "sliding": TASK | {"clips": 40, "generated": 0.95},
    "by_type": {"T1 seen": 0.99, "T1 held_out": 0.5, "T2 seen": 0.75, "T2 held_out": 0.25},
    "false_directions": 0.045,
}


def cells(line):
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_every_score_stands_in_its_row_and_column():
    config = {"dgr_validation_accuracy": {"paper": 0.91, "grounded": 0.93}}
    text = training_overview(RunRecord("train", "geotlm-lm train", 0, 60.0, NUMBERS, config))
    tasks, claimed, types, _ = text.split("\n\n")
    header, _, turns, slides = tasks.splitlines()
    assert cells(header)[2:] == [
        "generated",
        "held-out wordings",
        "probe on z",
        "probe on c, no DGR",
    ]
    assert cells(turns) == ["rotation", "30", "0.900", "0.800", "0.700", "0.600"]
    assert cells(slides) == ["sliding", "40", "0.950", "0.800", "0.700", "0.600"]
    assert claimed.startswith("A direction is claimed of 4.5 % of the clips that have none.")
    assert claimed.endswith("paper 0.910, grounded 0.930.")
    assert [cells(line) for line in types.splitlines()[2:]] == [
        ["T1", "0.990", "0.500"],
        ["T2", "0.750", "0.250"],
    ]
