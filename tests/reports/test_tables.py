import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.experiments.compare import Case, Reply, compare
from geotlm_lm.reports.tables import (
    accuracy_overview,
    difference_overview,
    evaluation_tables,
    markdown,
    method_table,
    time_overview,
)


@pytest.fixture
def record():
    clip = Clip(np.zeros((1, 8, 8, 3), np.uint8))
    cases = [Case(clip, Motion.CLOCKWISE, f"cap {k}", f"cap {k}", {}) for k in range(3)]
    cases.append(Case(clip, Motion.COUNTERCLOCKWISE, "key", "key", {}))
    methods = {
        "cw only": lambda clip, among: Reply(Motion.CLOCKWISE, 12.34),
        "mute": lambda clip, among: Reply(None, 0.5),
    }
    table = compare(methods, cases, ROTATIONS, [("cw only", "mute")])
    table |= {"unreadable_left_out": 7, "rows_left_out": {"up-left": 2}}
    return RunRecord(
        name="evaluate",
        command="geotlm-lm evaluate --clips 4",
        seed=9,
        seconds=120.0,
        numbers={"tables": {"simulated rotation": table}, "minimum": 0.75},
        commit="abc",
        machine={"cores": 2, "processor": "Slow 1"},
        made_utc="2026-01-02T03:04:05Z",
    )


def test_a_table_is_padded_so_that_it_reads_as_text():
    assert markdown(["name", "n"], [["a", "1"], ["longer", "23"]]) == (
        "| name   |  n |\n| ------ | -: |\n| a      |  1 |\n| longer | 23 |"
    )


def test_a_method_row_names_the_class_it_is_worst_at(record):
    rows = method_table(record.numbers["tables"]["simulated rotation"]).splitlines()
    cells = [cell.strip() for cell in rows[2].strip("|").split("|")]
    assert cells[0] == "cw only"
    assert cells[1] == "0.750"
    assert cells[4] == "0.000 (counterclockwise)"
    assert cells[6:] == ["12.3", "12.3"]


def test_answers_without_a_direction_are_shown(record):
    rows = method_table(record.numbers["tables"]["simulated rotation"]).splitlines()
    assert [cell.strip() for cell in rows[3].strip("|").split("|")][5] == "4"


def test_the_tables_say_what_was_left_out_and_how_the_rows_differ(record):
    text = evaluation_tables(record)
    assert (
        "4 clips of 4 objects: 3 clockwise, 1 counterclockwise; 7 left out, their images do not "
        "show the motion; labels left out: 2 up-left."
    ) in text
    assert "- cw only less mute: +0.750 (" in text


def test_the_overview_has_a_row_per_table_and_the_way_to_get_it_again(record):
    text = accuracy_overview(record)
    assert "| simulated rotation | 4 |       4 | 0.750 (" in text
    assert text.endswith(
        "`geotlm-lm evaluate --clips 4` at commit abc, seed 9, 2.0 min on 2 cores of Slow 1, "
        "2026-01-02."
    )


def test_differences_have_a_row_each(record):
    assert "| simulated rotation | cw only less mute |     +0.750 |" in difference_overview(record)


def test_times_have_a_row_per_method(record):
    lines = time_overview(record).splitlines()
    assert [line.split("|")[2].strip() for line in lines[2:4]] == ["12.3 / 12.3", "0.5 / 0.5"]
