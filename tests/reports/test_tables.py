import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.experiments.compare import Case, Reply, compare
from geotlm_lm.reports.headline import (
    WORDS,
    accuracy_headline,
    difference_headline,
    time_headline,
)
from geotlm_lm.reports.tables import (
    evaluation_page,
    evaluation_tables,
    markdown,
    method_table,
)

PROVENANCE = (
    "`geotlm-lm evaluate --clips 4` at commit abc, seed 9, 2.0 min on 2 cores of Slow 1, "
    "2026-01-02."
)


@pytest.fixture
def record():
    clip = Clip(np.zeros((1, 8, 8, 3), np.uint8))
    cases = [Case(clip, Motion.CLOCKWISE, f"cap {k}", f"cap {k}", {}) for k in range(3)]
    cases.append(Case(clip, Motion.COUNTERCLOCKWISE, "key", "key", {}))
    methods = {
        WORDS: lambda clip, among: Reply(Motion.CLOCKWISE, 12.34),
        "mute": lambda clip, among: Reply(None, 0.5),
    }
    table = compare(methods, cases, ROTATIONS, [(WORDS, "mute")])
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


def test_a_column_of_single_letters_still_has_a_rule():
    assert markdown(["a", "n"], [["b", "1"]]).splitlines()[1] == "| -- | -: |"


def test_a_method_row_names_the_class_it_is_worst_at(record):
    rows = method_table(record.numbers["tables"]["simulated rotation"]).splitlines()
    cells = [cell.strip() for cell in rows[2].strip("|").split("|")]
    assert cells[0] == WORDS
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
    assert f"- {WORDS} less mute: +0.750 (" in text


def test_the_page_holds_every_table_and_the_way_to_get_it_again(record):
    text = evaluation_page(record)
    assert evaluation_tables(record) in text
    assert text.endswith(PROVENANCE + "\n")


def test_the_headline_has_a_row_per_table_with_the_interval_of_the_words(record):
    lines = accuracy_headline(record).splitlines()
    assert cells(lines[0]) == ["clips", "n", "words", "mute", "words, 95 %"]
    low, high = record.numbers["tables"]["simulated rotation"]["methods"][WORDS]["interval"]
    interval = f"{low:.3f}-{high:.3f}"
    assert cells(lines[2]) == ["simulated rotation", "4", "0.750", "0.000", interval]
    assert lines[-1] == PROVENANCE


def test_the_headline_leaves_fine_shares_to_the_page(record):
    tables = record.numbers["tables"]
    table = tables["simulated rotation"]
    for title in ("real x, four frames, forwards", "real x, pairs, forwards", "real x, 10 fps"):
        tables[title] = table
    shown = [cells(line)[0] for line in accuracy_headline(record).splitlines()[2:4]]
    assert shown == ["simulated rotation", "real x, four frames, forwards"]
    assert len(cells(difference_headline(record).splitlines()[0])) == 2


def test_differences_have_a_row_per_pair_and_a_column_per_table(record):
    lines = difference_headline(record).splitlines()
    assert cells(lines[0]) == ["difference, 95 %", "simulated rotation"]
    assert cells(lines[2])[0] == "words less mute"
    assert cells(lines[2])[1].startswith("+0.750 (")


def test_times_have_a_row_per_method(record):
    lines = time_headline(record).splitlines()
    assert [cells(line)[1] for line in lines[2:4]] == ["12.3 / 12.3", "0.5 / 0.5"]


def cells(line):
    return [cell.strip() for cell in line.strip("|").split("|")]
