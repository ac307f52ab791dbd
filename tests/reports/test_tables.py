import json

import numpy as np
import pytest

from geotlm_lm.answering import Answer
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import REGIONS
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.experiments.compare import Case, Reply, compare
from geotlm_lm.reports.facts import facts
from geotlm_lm.reports.headline import (
    WORDS,
    accuracy_headline,
    difference_headline,
    false_claim_headline,
    time_headline,
)
from geotlm_lm.reports.tables import (
    answer_example,
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


@pytest.mark.parametrize("part", ["no idle frame", "whole recordings", "turned by a quarter"])
def test_tables_beside_the_main_ones_get_no_column(record, part):
    tables = record.numbers["tables"]
    tables[f"real x, {part}"] = tables["simulated rotation"]
    assert len(cells(difference_headline(record).splitlines()[0])) == 2
    assert len(cells(time_headline(record).splitlines()[0])) == 2
    assert f"| real x, {part} " in accuracy_headline(record)
    assert f"### real x, {part}\n" in evaluation_page(record)


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


def test_false_claims_stand_beside_clips_without_a_direction():
    clip = Clip(np.zeros((1, 8, 8, 3), np.uint8))
    cases = [Case(clip, motion, "gel", "gel", {}) for motion in (Motion.NONE, Motion.STILL)]
    said = iter([Motion.LEFT, Motion.STILL])
    table = compare({"m": lambda clip, among: Reply(next(said), 1.0)}, cases, tuple(Motion))
    header, _, row = method_table(table).splitlines()
    assert cells(row)[cells(header).index("direction claimed where none is")] == "0.500"


def test_clips_with_a_direction_have_no_column_of_false_claims(record):
    assert "claimed" not in method_table(record.numbers["tables"]["simulated rotation"])


def test_the_first_page_tells_false_claims_by_table_and_method(record):
    tables = record.numbers["tables"]
    methods = tables["simulated rotation"]["methods"]
    undirected = {name: scores | {"false_claim_rate": 0.25} for name, scores in methods.items()}
    truths = {"none": 5, "still": 2, "left": 3}
    tables["real x, untouched"] = {"truths": truths, "methods": undirected}
    lines = false_claim_headline(record).splitlines()
    assert cells(lines[0]) == ["clips without a direction", "n", "words", "mute"]
    assert cells(lines[2]) == ["real x, untouched", "7", "0.250", "0.250"]
    assert lines[3] == ""


def test_claims_that_turn_round_with_the_clip_stand_below_their_table(record):
    tables = record.numbers["tables"]
    methods = tables["simulated rotation"]["methods"]
    undirected = {name: scores | {"false_claim_rate": 0.5} for name, scores in methods.items()}
    claimed = {WORDS: {"directions": 3, "turned_round": 2}}
    tables["real x, pressed in"] = {
        "truths": {"press": 6},
        "methods": undirected,
        "claims": claimed,
    }
    row = false_claim_headline(record).splitlines()[3]
    assert cells(row) == ["of these, the opposite when played backwards", "", "2 of 3", "-"]


def test_objects_are_listed_under_their_table(record):
    table = record.numbers["tables"]["simulated rotation"]
    table["by_object"] = {"cap": {"clips": 3, WORDS: 1.0}, "key": {"clips": 1, WORDS: 0.0}}
    lines = evaluation_tables(record).splitlines()
    begin = lines.index("Object by object:")
    assert cells(lines[begin + 2]) == ["object", "clips", WORDS]
    assert cells(lines[begin + 4]) == ["cap", "3", "1.000"]


RULE = {
    "gap_frames": 10,
    "least_turn_deg": 5.0,
    "most_aside_px": 10.0,
    "least_slide_px": 12.5,
    "most_aside_deg": 4.0,
    "least_purity": 0.92,
    "most_tilt_deg": 5.0,
    "most_lift_mm": 0.5,
    "least_contact_px": 500,
}


def test_a_table_of_pairs_states_its_thresholds(record):
    table = record.numbers["tables"]["simulated rotation"]
    table["pairs"] = {"rule": RULE, "found": 77, "paper": 4088, "paper_share": 0.25}
    text = facts(table)
    assert "Pairs 10 frames apart; a rotation turns by 5 degrees or more and travels" in text
    assert "a slide travels 12.5 px or more, 0.92 of it along its axis, and turns by at" in text
    assert text.endswith(
        "77 pairs are such; the paper, which gives no threshold, has 4088 in all trials, of which "
        "25% are here."
    )


def test_recordings_shorter_than_a_window_are_said(record):
    table = record.numbers["tables"]["simulated rotation"] | {"too_short_left_out": 3}
    assert "3 recordings left out, shorter than a window" in facts(table)


def test_what_a_data_set_lacks_and_how_thresholds_were_swept_is_told(record):
    sweep = [
        {"gap_frames": gap, "least": least, "pairs": int(gap * least), "of": {}}
        for gap in (5, 10)
        for least in (2.0, 3.5)
    ]
    record.numbers["data_sets"] = {
        "TactileTracking x": {
            "left_out": {"count": 2, "first": ["key0: gone.", "key1: gone."]},
            "backgrounds": {"trials": 3, "share": 0.125},
            "sweeps": {"rotation": sweep},
        }
    }
    text = evaluation_tables(record)
    assert "### TactileTracking x: files and thresholds" in text
    assert "2 trials or clips left out because their files cannot be used. key0: gone." in text
    assert "Backgrounds: trials: 3; share: 12.5%." in text
    lines = text.splitlines()
    begin = lines.index("Pairs of frames that count as rotation, by gap and least degrees:")
    assert cells(lines[begin + 2]) == ["gap", "2", "3.5"]
    assert cells(lines[begin + 5]) == ["10 frames", "20", "35"]


def test_the_page_shows_a_picture_per_whole_table(record):
    tables = record.numbers["tables"]
    tables["simulated rotation, pairs, forwards"] = tables["simulated rotation"]
    text = evaluation_page(record)
    assert text.count("![") == 1
    assert "![simulated rotation](confusions/simulated-rotation.png)" in text


def is_part(shown, whole):
    """Tell whether every field shown stands at the same place in the whole, with its value."""
    if not isinstance(shown, dict):
        return shown == whole
    return all(name in whole and is_part(value, whole[name]) for name, value in shown.items())


def test_the_example_for_programs_nests_its_fields_as_the_answer_does():
    region = {"shear_change_x": 2.2, "shear_change_y": 0.6, "contact_mass": 0.1}
    answer = Answer(
        text="Left.", direction=Motion.LEFT, confidence=0.9, abstained=False, frame=FrameSpec(),
        options={"left": 0.9}, evidence={"regions": dict.fromkeys(REGIONS, region)}, timing_ms={},
        kind="direction", frames_used=(0, 1, 2, 3),
    ).to_dict()  # fmt: skip
    numbers = {"shown": "geotlm-lm answer", "answer": answer, "cold_s": [1.0, 2.0, 3.0]}
    text = answer_example(RunRecord("answer", "geotlm-lm report answer", 0, 60.0, numbers))
    shown = json.loads(text.split("```json")[1].split("```")[0])
    assert is_part(shown, answer)
    assert shown["evidence"]["regions"]["upper_minus_lower"] == region
    assert "takes 2.0 s (median of 3, 1.0-3.0 s)." in text
