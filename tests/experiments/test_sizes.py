"""Language models of several sizes: every row is of its own model, and a stopped run goes on."""

import pytest

from geotlm_lm.answering import Answerer
from geotlm_lm.cli.main import main
from geotlm_lm.core.errors import UsageError
from geotlm_lm.experiments import sizes as experiment
from geotlm_lm.experiments.sizes import SHIPPED, SIZES, Budget, compare_sizes
from geotlm_lm.language.decoder import LanguageSize
from geotlm_lm.reports.sizes import sizes_page, sizes_table
from geotlm_lm.training import examples
from tests.tiny_bundle import tiny_bundle
from tests.training.in_process import InProcess

SMALL = LanguageSize(width=16, layers=1, heads=2, mlp=16)
LARGER = LanguageSize(width=32, layers=1, heads=2, mlp=16, tactile_tokens=3)


@pytest.fixture(scope="module")
def answerer():
    return Answerer(tiny_bundle())


@pytest.fixture
def run(monkeypatch, tmp_path, answerer):
    monkeypatch.setattr(examples, "CHUNK_CLIPS", 12)
    monkeypatch.setattr(examples, "ProcessPoolExecutor", InProcess)

    def compare(**sizes):
        return compare_sizes(
            answerer,
            folder=tmp_path,
            budget=Budget(clips=12, test_clips=12, steps=2, batch=4),
            seed=0,
            workers=1,
            sizes=sizes,
        )

    return compare


def test_every_size_is_trained_asked_and_timed_and_a_second_run_only_asks(run, monkeypatch):
    record = run(small=SMALL, larger=LARGER)
    first, second = record.numbers["rows"]
    assert first["parameters"] < second["parameters"]
    for row in (first, second):
        assert 0 < row["weigh_ms_median"] <= row["weigh_ms_p95"]
        assert 0 < row["write_ms_median"] <= row["write_ms_p95"]
        assert all(0 <= share <= 1 for share in row["by_type"].values())
    monkeypatch.setattr("geotlm_lm.training.language._step", lambda *_: pytest.fail("trained"))
    again = run(small=SMALL).numbers["rows"][0]
    assert again["by_type"] == first["by_type"]
    page = sizes_page(record)
    assert sizes_table(record) in page
    assert "trained for 2 steps of 4 questions on the same " in page


def test_the_shipped_size_is_among_those_compared_with_three_counts_of_prefix_tokens():
    assert list(SIZES.values()).count(SHIPPED) == 1
    assert {size.tactile_tokens for size in SIZES.values()} == {1, 2, 4}
    assert len({(size.width, size.layers) for size in SIZES.values()}) >= 3


def test_the_command_writes_record_and_table(run, monkeypatch, tmp_path, answerer, capsys):
    record = run(small=SMALL)
    monkeypatch.setattr(Answerer, "load", lambda folder: answerer)
    asked = []

    def compare(answerer, **given):
        asked.append((answerer, given["budget"], given["seed"], given["workers"], given["folder"]))
        return record

    monkeypatch.setattr(experiment, "compare_sizes", compare)
    out, table = tmp_path / "sizes.json", tmp_path / "sizes.md"
    arguments = ["--run-folder", str(tmp_path / "run"), "--out", str(out), "--table", str(table)]
    arguments += ["--clips", "200", "--test-clips", "30", "--steps", "7"]
    arguments += ["--seed", "5", "--workers", "3"]
    with pytest.raises(SystemExit) as stopped:
        main(["report", "sizes", *arguments])
    assert stopped.value.code == 0
    assert asked == [(answerer, Budget(200, 30, 7), 5, 3, tmp_path / "run")]
    assert sizes_table(record) in capsys.readouterr().out
    assert table.read_text() == sizes_page(record)
    assert out.is_file()


def test_clips_of_another_seed_are_not_taken_for_this_ones(run, tmp_path, answerer):
    run(small=SMALL)
    with pytest.raises(UsageError, match="holds a run of another preset, seed or version"):
        compare_sizes(answerer, folder=tmp_path, budget=Budget(), seed=1, workers=1)
