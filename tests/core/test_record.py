"""A record comes back as it was written, and says where it was made."""

import json

from geotlm_lm.core.record import RunRecord


def test_a_record_survives_its_file(tmp_path):
    record = RunRecord("evaluate", "geotlm-lm evaluate", 3, 1.5, {"accuracy": 0.75}, {"count": 4})
    record.save(tmp_path / "folder" / "record.json")
    assert RunRecord.load(tmp_path / "folder" / "record.json") == record


def test_a_record_says_on_which_machine_it_was_made(tmp_path):
    record = RunRecord("evaluate", "", 0, 0.0, {})
    assert record.machine["cores"] >= 1
    assert record.machine["versions"]["numpy"] != "absent"
    json.dumps(record.machine)
