"""The front, the picks and the page of error against run time."""

import pytest

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.pareto import is_on_front, picks
from geotlm_lm.reports.runtime import (
    draw_runtime,
    method_table,
    omission_table,
    pick_table,
    runtime_headline,
    runtime_page,
)


def row(method, error, ms, source="rotation", frames=4, p95=None):
    return {
        "method": method,
        "source": source,
        "frames": frames,
        "clips": 10,
        "error": error,
        "error_interval": [0.0, 0.3],
        "turn_error_deg": 1.25,
        "slide_error_px": None,
        "ms_q25": ms,
        "ms_median": ms,
        "ms_q75": ms,
        "ms_p95": p95 or ms,
    }


ROWS = [
    row("flow + fit, fast", 0.10, 5.0),
    row("probe on z", 0.02, 30.0, p95=38.0),
    row("LM scored", 0.02, 36.0, p95=45.0),
    row("LM generated", 0.00, 42.0, p95=60.0),
    row("LM generated, int8", 0.005, 39.0, p95=50.0),
    row("Curl + LR", 0.0, 4.0),
]
BATCHES = [
    {"work": work, "precision": "float32", "threads": threads, "batch": batch}
    | {"ms_median": ms, "ms_q25": ms, "ms_q75": ms, "ms_p95": ms}
    for work, threads, batch, ms in (
        ("probe on z", 1, 1, 30.0),
        ("probe on z", 2, 32, 10.0),
        ("LM generated", 1, 1, 42.0),
        ("LM generated", 2, 32, 12.5),
        ("flow + fit, fast", 2, 32, 2.0),
        ("perceive", 2, 32, 9.0),
    )
]
NUMBERS = {
    # A slide has no curl: the method that tells turns alone has no row there.
    "methods": ROWS + [one | {"source": "sliding"} for one in ROWS if one["method"] != "Curl + LR"],
    "batches": BATCHES,
    "stages": [
        {"stage": "backbone"} | dict.fromkeys(("ms_q25", "ms_median", "ms_q75", "ms_p95"), 9)
    ],
    "memory": [{"way": "flow + fit", "megabytes": 81.4}],
    "commands": [
        {"command": "answer", "seconds": [1.5, 1.75, 2.5], "import_s": 1.2}
        | {"packages_s": {"torch": 0.9, "numpy": 0.1, "other": 0.2}}
    ],
    "omissions": [
        {"omission": "encoding again", "when": "3 questions"}
        | {"full_ms": [90.0, 100.0, 95.0], "lean_ms": [40.0, 40.0, 45.0]}
    ],
}


@pytest.fixture
def record():
    return RunRecord("runtime", "geotlm-lm report runtime", 0, 600.0, NUMBERS, {"left_out": []})


def test_the_front_holds_what_nothing_beats_in_both():
    on_front = [one["method"] for one in ROWS if is_on_front(one, ROWS)]
    assert on_front == ["Curl + LR"]
    others = ROWS[:-1]
    assert [one["method"] for one in others if is_on_front(one, others)] == [
        "flow + fit, fast",
        "probe on z",
        "LM generated",
        "LM generated, int8",
    ]


def test_equals_do_not_push_each_other_off_the_front():
    twins = [row("a", 0.1, 5.0), row("b", 0.1, 5.0)]
    assert all(is_on_front(one, twins) for one in twins)


def test_each_use_gets_what_its_rule_says():
    loop, batch, chat = picks(NUMBERS)
    # Curl + LR is faster and better, and knows no slides; the scored answers are too late.
    assert (loop.method, loop.error) == ("probe on z", 0.02)
    # Within 0.01 of the least error that a batch has, only the words remain.
    assert (batch.method, batch.cost) == (
        "LM generated",
        "80 clips a second in batches of 32, 2 threads",
    )
    assert (chat.method, chat.cost) == ("LM generated, int8", "39.0 ms a clip, p95 50.0")


def test_a_loop_keeps_its_time_on_every_source_or_is_none():
    rows = [row("steady", 0.1, 20.0, p95=39.0), row("quick", 0.05, 5.0, p95=8.0)]
    rows += [row("steady", 0.1, 20.0, "sliding", p95=39.0)]
    rows += [row("quick", 0.05, 5.0, "sliding", p95=41.0)]
    loop, *_ = picks({"methods": rows, "batches": []})
    assert loop.method == "steady"


def test_of_batches_alike_in_error_the_fastest_is_picked():
    rows = [row(name, error, 30.0) for name, error in (("a", 0.02), ("b", 0.025), ("c", 0.1))]
    batches = [
        BATCHES[0] | {"work": name, "ms_median": ms} for name, ms in (("a", 9), ("b", 8), ("c", 1))
    ]
    _, batch, _ = picks({"methods": rows, "batches": batches})
    assert (batch.method, batch.cost) == ("b", "125 clips a second in batches of 1, 1 thread")


def test_where_nothing_is_in_time_nothing_is_picked():
    slow = {"methods": [row("LM generated", 0.0, 90.0)], "batches": []}
    loop, batch, _ = picks(slow)
    assert loop.method is batch.method is None


def test_a_row_shows_its_error_its_measure_and_its_spread():
    line = method_table(ROWS).splitlines()[2]
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells == [
        "flow + fit, fast",
        "0.100",
        "0.000-0.300",
        "1.2",
        "-",
        "5.0",
        "5.0",
        "5.0-5.0",
    ]
    assert "| Curl + LR *" in method_table(ROWS)


def test_an_omission_is_told_by_its_median_saving():
    line = omission_table(NUMBERS["omissions"]).splitlines()[2]
    assert [cell.strip() for cell in line.strip("|").split("|")] == [
        "encoding again",
        "3 questions",
        "95.0",
        "40.0",
        "50.0 (50.0 to 60.0)",
    ]


def test_the_page_holds_every_part(record):
    page = runtime_page(record)
    for words in (
        "| a robot's loop ",
        "### rotation, 4 frames, 10 clips",
        "### sliding, 4 frames, 10 clips",
        "| probe on z, float32, 2 threads ",
        "torch 0.90, other 0.20, numpy 0.10",
        "1.75 (1.50-2.50)",
        "| flow + fit | ",
    ):
        assert words in page
    gain = next(line for line in page.splitlines() if line.startswith("| LM generated, float32, 1"))
    assert gain.split("|")[-2].strip() == "1.0"


def test_the_headline_is_the_picks_and_the_stages(record):
    headline = runtime_headline(record)
    assert headline.startswith(pick_table(record))
    assert all(part in runtime_page(record) for part in headline.split("\n\n"))
    assert "### rotation" not in headline


def test_the_figure_draws_every_source(record, tmp_path):
    draw_runtime(record, tmp_path / "runtime.png")
    assert (tmp_path / "runtime.png").stat().st_size > 5_000
