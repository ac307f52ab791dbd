import pytest

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports import readme
from geotlm_lm.reports.readme import UnusableReadme, check_readme, fill_blocks, write_readme

TEXT = """# Title

<!-- begin: accuracy -->
old numbers
<!-- end: accuracy -->

After.
"""


@pytest.fixture
def records(tmp_path, monkeypatch):
    monkeypatch.setitem(
        readme.BLOCKS, "accuracy", ("evaluate.json", lambda record: f"| {record.seed} |")
    )
    monkeypatch.setattr(readme, "PAGES", {})
    folder = tmp_path / "recorded"
    RunRecord("evaluate", "geotlm-lm evaluate", 7, 1.0, {}).save(folder / "evaluate.json")
    return folder


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "README.md"
    path.write_text(TEXT)
    return path


def test_only_what_stands_between_the_marks_is_replaced(records):
    assert fill_blocks(TEXT, records) == TEXT.replace("old numbers\n", "\n| 7 |\n\n")


def test_filling_twice_changes_nothing_more(records):
    once = fill_blocks(TEXT, records)
    assert fill_blocks(once, records) == once


def test_text_without_blocks_stays_as_it_is(records):
    assert fill_blocks("# No numbers\n", records) == "# No numbers\n"


def test_every_block_is_filled(records):
    assert fill_blocks(TEXT + TEXT, records).count("| 7 |") == 2


def test_a_changed_record_fails_the_check_until_it_is_written(file, records):
    assert write_readme(file, records)
    check_readme(file, records)
    RunRecord("evaluate", "geotlm-lm evaluate", 8, 1.0, {}).save(records / "evaluate.json")
    with pytest.raises(UnusableReadme, match="its numbers differ from the records"):
        check_readme(file, records)
    assert write_readme(file, records)
    assert not write_readme(file, records)


def test_a_page_is_written_beside_the_records_and_checked(file, records, monkeypatch):
    page = {"evaluation.md": ("evaluate.json", lambda record: f"seed {record.seed}")}
    monkeypatch.setattr(readme, "PAGES", page)
    write_readme(file, records)
    written = records.parent / "evaluation.md"
    assert written.read_text() == "seed 7"
    written.write_text("seed 8")
    with pytest.raises(UnusableReadme, match=r"evaluation.md: its numbers differ"):
        check_readme(file, records)


def test_a_page_without_its_record_is_not_written(file, records, monkeypatch):
    monkeypatch.setattr(readme, "PAGES", {"other.md": ("other.json", lambda record: "")})
    write_readme(file, records)
    assert not (records.parent / "other.md").exists()


def test_checking_never_writes(file, records):
    with pytest.raises(UnusableReadme, match="differ"):
        check_readme(file, records)
    assert file.read_text() == TEXT


def test_a_missing_record_names_the_command_that_writes_it(tmp_path):
    with pytest.raises(UnusableReadme, match=r"evaluate.json: the record of block 'accuracy' is"):
        fill_blocks(TEXT, tmp_path)


def test_an_unknown_block_is_refused(records):
    with pytest.raises(UnusableReadme, match="block 'speed' is not known; expected one of"):
        fill_blocks("<!-- begin: speed -->\n<!-- end: speed -->\n", records)


def test_an_open_block_is_refused(records):
    with pytest.raises(UnusableReadme, match="block 'accuracy' is not closed"):
        fill_blocks("<!-- begin: accuracy -->\n", records)


def test_a_missing_readme_is_refused(tmp_path, records):
    with pytest.raises(UnusableReadme, match="cannot be read"):
        check_readme(tmp_path / "gone.md", records)


def test_pictures_of_older_numbers_fail_the_check(file, records, monkeypatch):
    """The picture that was drawn is fresh until the record's numbers change."""
    pytest.importorskip("matplotlib", reason="pictures need matplotlib (extra: eval)")
    from geotlm_lm.reports.confusions import draw_confusions

    page = {"evaluation.md": ("evaluate.json", lambda record: "page")}
    monkeypatch.setattr(readme, "PAGES", page)

    def recorded(right):
        confusion = {"labels": ["left", "right"], "counts": [[right, 5 - right, 0], [0, 5, 0]]}
        table = {"truths": {"left": 5, "right": 5}, "methods": {"m": {"confusion": confusion}}}
        record = RunRecord("evaluate", "", 0, 1.0, {"tables": {"simulated sliding": table}})
        record.save(records / "evaluate.json")
        write_readme(file, records)
        return record

    missing = r"simulated-sliding.png: is missing or shows other numbers .* report confusions"
    record = recorded(3)
    with pytest.raises(UnusableReadme, match=missing):
        check_readme(file, records)
    draw_confusions(record, records.parent / "confusions")
    check_readme(file, records)
    recorded(4)
    with pytest.raises(UnusableReadme, match=missing):
        check_readme(file, records)
