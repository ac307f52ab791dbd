"""A record comes back as it was written, and says where it was made."""

import pytest

from geotlm_lm.core.record import RunRecord, UnreadableRecord


def test_a_record_survives_its_file(tmp_path):
    record = RunRecord("evaluate", "geotlm-lm evaluate", 3, 1.5, {"accuracy": 0.75}, {"count": 4})
    record.save(tmp_path / "folder" / "record.json")
    assert RunRecord.load(tmp_path / "folder" / "record.json") == record


@pytest.mark.parametrize(
    "text",
    ["", "no JSON", "[1]", '{"name": "a"}', "[" * 100_000, '{"stranger": 1}'],
    ids=lambda text: text[:12] or "empty",
)
def test_a_file_that_is_no_record_is_one_sentence(tmp_path, text):
    (tmp_path / "run.json").write_text(text)
    with pytest.raises(UnreadableRecord) as caught:
        RunRecord.load(tmp_path / "run.json")
    assert str(caught.value).startswith(f"{tmp_path}/run.json: is no record of a run (")
    assert str(caught.value).endswith("; make it again by the command that wrote it.")
