"""The page of the model's stability says what fails, by name, and shows every row."""

import pytest

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.stability import draw_fall, stability_page, summary


def row(case, level="-", group="damage", **values):
    counts = {"right": 0, "wrong": 0, "abstained": 0, "refused": 0, "crashed": 0}
    return {
        "group": group,
        "case": case,
        "level": level,
        "unit": "px" if level != "-" else "",
        "clips": 4,
        **counts,
        "accuracy_of_answers": None,
        "confidence": None,
        "confidence_wrong": None,
        "false_directions": 0,
        "confident_false_directions": 0,
        "confident_oversights": 0,
        "says": "Clockwise.",
        "slowest_s": 0.2,
    } | values


ROWS = [
    row("small", "56", right=4, accuracy_of_answers=1.0, confidence=0.9),
    row(
        "small",
        "8",
        right=2,
        wrong=2,
        accuracy_of_answers=0.5,
        confidence=0.7,
        confidence_wrong=0.96,
        false_directions=1,
        confident_false_directions=1,
    ),
    row("black", group="extreme", refused=4, says="x: 100% of | frame 0 is black"),
    row("friction 1e6", group="stiff scene", crashed=1, slowest_s=3.0, solver="good, converged"),
]
NUMERICS = {
    "mass_floor": [
        {"mask": 1e-8, "contact": "everywhere", "global": 0.66, "recovered": 1.0, "mass": 1e-8}
        | {"upper_minus_lower": 0.0, "mass_upper_minus_lower": 1e-8}
    ],
    "gradients": [{"mask": 1.0, "by_field": 0.1, "by_mask": 0.2, "by_logit": 0.0, "checked": True}],
    "precision": [
        {"parts": "geometry", "precision": "bfloat16", "descriptor_error": 4e-3}
        | {"is_finite": True, "answers_changed": 1, "confidence_change": 0.2}
        | {"right": 19, "clips": 20}
    ],
    "scales": [
        {"factor": 1e4, "statistics": "as shipped", "abstained": 3, "confidence": None}
        | {"right": 2, "clips": 20}
    ],
}


@pytest.fixture
def record():
    return RunRecord("stability", "geotlm-lm report stability", 0, 60.0, {"rows": ROWS} | NUMERICS)


def test_the_summary_names_crashes_and_confident_mistakes(record):
    assert summary(record).splitlines() == [
        "- crashed: stiff scene: friction 1e6 of 4 rows",
        "- a wrong direction at 0.9 or more: small, 8 px 1/4",
        "- a touch or motion overlooked at 0.9 or more: none",
        "- slowest answer: 3.0 s",
        "- mean probability less share right, over the levels of damage: +0.05 on average, "
        "+0.20 at worst (small, 8 px)",
    ]


def test_the_page_shows_every_row_with_its_outcome(record):
    page = stability_page(record)
    line = next(line for line in page.splitlines() if line.startswith("| small, 8 px"))
    assert [cell.strip() for cell in line.strip("|").split("|")] == [
        "small, 8 px",
        "4",
        "2",
        "2",
        "-",
        "-",
        "-",
        "1",
        "0.50",
        "0.70",
        "0.96",
        "Clockwise.",
    ]
    assert "100% of / frame 0 is black" in page  # a bar would end the cell
    assert "Clockwise. [good, converged]" in page
    for words in ("1e-08, everywhere", "bfloat16: geometry", "1 of 20", "10000, statistics"):
        assert words in page


def test_the_figure_draws_what_has_levels(record, tmp_path):
    draw_fall(record, tmp_path / "fall.png")
    assert (tmp_path / "fall.png").stat().st_size > 5_000
