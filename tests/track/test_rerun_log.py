"""Recordings for Rerun, read back by its own reader: what is expected is the track."""

import os

import numpy as np
import pytest

from geotlm_lm.core.errors import MissingDependency
from geotlm_lm.track import export
from geotlm_lm.track.export import Exported
from geotlm_lm.track.rerun_log import log_answer, log_clip, log_track, rerun_recording
from geotlm_lm.track.tracker import track_of
from tests.data_sets.lerobot_files import turned

chunks = pytest.importorskip("rerun.chunk", reason="needs rerun-sdk, of the extra rerun")

CLIP = turned(20)


def read(path):
    """Return the tables that a recording holds of each entity."""
    found = {}
    for chunk in chunks.RrdReader(path).stream():
        found.setdefault(chunk.entity_path, []).append(chunk.to_record_batch())
    return found


def column(tables, component):
    """Return the values of a component in the order of the frames."""
    rows = [
        (row["frame"], row[component])
        for table in tables
        for row in table.to_pylist()
        if row.get(component) is not None
    ]
    return [value for _, value in sorted(rows, key=lambda one: one[0])]


@pytest.fixture(scope="module")
def logged(tmp_path_factory):
    path = tmp_path_factory.mktemp("rerun") / "new" / "out.rrd"
    track = track_of(CLIP, idle=CLIP.frames[0])
    with rerun_recording(path) as stream:
        log_track(stream, Exported(track, mm_per_px=0.06), CLIP)
        log_answer(stream, "Which way?", "Clockwise.", ["Tracked from frame 0 to 23."])
    return track, read(path), path


def test_curves_hold_the_track_with_its_spans(logged):
    track, found, _ = logged
    turn = np.array(column(found["/turn/deg"], "Scalars:scalars"))
    assert turn.shape == (len(track), 3)
    assert turn[:, 0] == pytest.approx(track.path_from_start[:, 0])
    assert turn[:, 2] - turn[:, 0] == pytest.approx(1.645 * track.path_deviations[:, 0])
    contact = np.ravel(column(found["/contact"], "Scalars:scalars"))
    assert contact == pytest.approx(track.contact)
    right = np.array(column(found["/travel/right_mm"], "Scalars:scalars"))[:, 0]
    across, _ = Exported(track, 0.06).units.travelled(track.path_from_start[:, 1], 0)
    assert right == pytest.approx(across)


def test_each_frame_has_its_picture_and_arrows(logged):
    track, found, _ = logged
    assert len(column(found["/camera/image"], "EncodedImage:blob")) == len(CLIP)
    hands = np.array(column(found["/camera/turn"], "Arrows2D:vectors"))[:, 0]
    told = np.degrees(np.arctan2(hands[:, 0], -hands[:, 1]))
    assert told == pytest.approx(track.path_from_start[:, 0], abs=1e-3)


def test_events_and_the_answer_are_texts(logged):
    track, found, _ = logged
    texts = [text for (text,) in column(found["/events"], "TextLog:text")]
    assert len(texts) == len(track.events)
    assert any(text.startswith("turn clockwise ") and " deg (" in text for text in texts)
    (told,) = found["/answer"]
    (text,) = told.to_pylist()[0]["TextDocument:text"]
    assert text == "**Which way?**\n\nClockwise.\n\n*Tracked from frame 0 to 23.*"


def test_a_recording_that_was_not_tracked_is_its_frames(tmp_path):
    path = tmp_path / os.fsdecode(b"m\xe9.rrd")
    with rerun_recording(path) as stream:
        log_clip(stream, CLIP.select([3, 9]))
    found = read(path.rename(tmp_path / "out.rrd"))
    (frames,) = [sorted(row["frame"] for t in found["/camera/image"] for row in t.to_pylist())]
    assert frames == [3, 9]


def test_an_error_leaves_no_file(tmp_path):
    with pytest.raises(RuntimeError, match="stop"), rerun_recording(tmp_path / "out.rrd"):
        raise RuntimeError("stop")
    assert list(tmp_path.iterdir()) == []


def test_without_rerun_the_extra_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(export, "find_spec", lambda name: None)
    with (
        pytest.raises(MissingDependency, match=r"with rerun, .*'geotlm-lm\[rerun\]'"),
        rerun_recording(tmp_path / "out.rrd"),
    ):
        pass
