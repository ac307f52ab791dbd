"""Whatever a reader does to a file is found, and a sound reader is left alone."""

import os
import time

import numpy as np

from geotlm_lm.benchmarks import stability_files
from geotlm_lm.benchmarks.stability_files import FORMATS, damaged_files, read_all

FRAMES = np.random.default_rng(0).integers(90, 110, (4, 24, 32, 3)).astype(np.uint8)


def test_every_format_is_read_sound_and_refused_empty(tmp_path):
    files = damaged_files(tmp_path, FRAMES, 2, 0)
    paths = [files[name, damage][0] for damage in ("sound", "empty") for name in FORMATS]
    ended = [one[0] for one in read_all(paths)]
    assert ended == ["read"] * len(FORMATS) + ["refused"] * len(FORMATS)


def broken_reader(path):
    if path.name == "waits":
        time.sleep(600)
    if path.name == "dies":
        os.abort()
    if path.name == "raises":
        raise ZeroDivisionError("a defect")


def read_with_a_broken_reader(paths, sent):
    """Read in the other process, which begins with the reader as it is shipped."""
    stability_files.read_clip = broken_reader
    READ_EACH(paths, sent)


READ_EACH = stability_files._read_each


def test_a_reader_that_fails_dies_or_hangs_is_found_and_the_others_still_read(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(stability_files, "_read_each", read_with_a_broken_reader)
    ended = list(read_all([tmp_path / name for name in ("raises", "dies", "sound")]))
    assert [one[0] for one in ended] == ["crashed", "crashed", "read"]
    assert ended[0][1] == "ZeroDivisionError: a defect"
    assert [one[0] for one in read_all([tmp_path / "waits"], hang_s=1.0)] == ["hung"]
