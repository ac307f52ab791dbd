"""The fuzzer finds each thing that must not happen, and survives it; a sound target it leaves."""

import random

import numpy as np
import pytest

from geotlm_lm.fuzzing import explore, mutate, run
from tests.fuzzing import broken


def fuzzed(tmp_path, prepare, seconds=1.0):
    return run.fuzz(
        {"it": prepare},
        seconds,
        tmp_path / "found",
        seed=0,
        command="test",
        progress=lambda *_: None,
    ).numbers


@pytest.mark.parametrize(
    ("prepare", "kind", "said"),
    [
        (broken.fails, "defect", "ZeroDivisionError: a defect"),
        (broken.dies, "crash", "the process ended with -6"),
    ],
    ids=["fails", "dies"],
)
def test_what_must_not_happen_is_found_and_its_input_kept(tmp_path, prepare, kind, said):
    finding = fuzzed(tmp_path, prepare)["findings"][0]
    assert finding["kind"] == kind
    assert finding["said"].startswith(said)
    kept = (tmp_path / "found" / finding["file"]).read_bytes()
    assert kept != broken.SEED
    assert len(kept) == finding["bytes"]


def run_once(run):
    counts = {"runs": 0, "read": 0, "slowest_ms": 0.0, "memory_mib": 0.0}
    findings = explore._run_once(run, b"data", explore.Reached(), counts)
    return [one["kind"] for one in findings], counts


def test_an_input_that_takes_long_is_found(monkeypatch):
    monkeypatch.setattr(explore, "SLOW_S", 0.05)
    kinds, counts = run_once(broken.works_for(0.2))
    assert kinds == ["slow"]
    assert counts["slowest_ms"] >= 200


def test_an_input_that_takes_much_memory_is_found(monkeypatch):
    monkeypatch.setattr(explore, "HEAVY_BYTES", 2**24)
    beyond = explore._peak_bytes() + 2**26  # what counts is the peak: go beyond the one so far
    kinds, counts = run_once(lambda data: np.ones(beyond, np.uint8))
    assert "heavy" in kinds
    assert counts["memory_mib"] > 16


@pytest.mark.parametrize("prepare", [broken.loops, broken.waits], ids=["working", "waiting"])
def test_a_hang_is_ended_and_its_input_kept(tmp_path, monkeypatch, prepare):
    monkeypatch.setattr(run, "HANG_S", 3.0)
    monkeypatch.setattr(run, "STUCK_S", 6.0)
    (finding,) = fuzzed(tmp_path, prepare)["findings"]
    assert finding["kind"] == "hang"
    assert (tmp_path / "found" / finding["file"]).read_bytes() != broken.SEED


def test_a_refusal_in_one_sentence_is_counted_and_nothing_else(tmp_path):
    numbers = fuzzed(tmp_path, broken.refuses)
    assert numbers["findings"] == []
    counts = numbers["targets"]["it"]
    assert counts["refused"] > 10
    assert counts["read"] + counts["refused"] == counts["runs"]


def test_what_reaches_new_lines_is_kept_and_damaged_further(monkeypatch):
    monkeypatch.setattr(explore, "WATCHED", (broken.__file__,))
    target, reached = broken.guarded(None), explore.Reached()
    kept = list(target.seeds)
    rng, counts = random.Random(0), {"runs": 0, "read": 0, "slowest_ms": 0.0, "memory_mib": 0.0}
    for _ in range(200_000):
        data, known = mutate.damaged(rng.choice(kept), kept, (), rng), len(reached.pairs)
        if explore._run_once(target.run, data, reached, counts):
            break
        if len(reached.pairs) > known:
            kept.append(data)
    # Blind damage would need the three letters at once: one chance in millions.
    assert counts["runs"] < 200_000
    assert any(data[:2] == b"FU" for data in kept)


@pytest.mark.parametrize("said", ["", "two\nlines", "x" * 4000], ids=["empty", "lines", "long"])
def test_a_refusal_that_is_no_sentence_is_untidy(said):
    assert not explore._is_one_sentence(said)


def test_damage_is_drawn_from_the_seed_alone():
    def draw(seed):
        rng = random.Random(seed)
        return [mutate.damaged(b"0123456789", [b"abc"], (b"word",), rng) for _ in range(50)]

    assert draw(1) == draw(1) != draw(2)
    assert len(set(draw(1))) > 20
