"""A record comes back as it was written, or not at all."""

import json

import pytest

from geotlm_lm.core.record import RunRecord, write_text_atomically


def test_a_record_survives_its_file(tmp_path):
    record = RunRecord("evaluate", "geotlm-lm evaluate", 3, 1.5, {"accuracy": 0.75}, {"count": 4})
    record.save(tmp_path / "folder" / "record.json")
    assert RunRecord.load(tmp_path / "folder" / "record.json") == record


def test_a_record_says_on_which_machine_it_was_made(tmp_path):
    record = RunRecord("evaluate", "", 0, 0.0, {})
    assert record.machine["cores"] >= 1
    assert record.machine["versions"]["numpy"] != "absent"
    json.dumps(record.machine)


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "record.json"
    write_text_atomically(path, "old")
    with pytest.raises(UnicodeEncodeError):
        write_text_atomically(path, "half \ud800")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
