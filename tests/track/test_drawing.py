"""One list of things to draw: what it holds of a track, and that film and Rerun show it."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import MissingDependency, UsageError
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.track import drawing
from geotlm_lm.track.drawing import (
    CAPTION_ROWS,
    DIAL_MARGIN,
    DIAL_PX,
    draw_mark,
    drawing_of,
    write_film,
)
from geotlm_lm.track.export import Exported
from geotlm_lm.track.rerun_log import log_answer, log_clip, log_track, rerun_recording
from geotlm_lm.track.tracker import track_of
from tests.data_sets.lerobot_files import turned
from tests.track.recordings import frame
from tests.track.tracks import happened, moving_track

FRAMES = [(number, frame(seed=number)) for number in range(9)]


def exported(turn=0.0, right=0.0, down=0.0, mm_per_px=None):
    steps = np.tile([turn, right, down, 0.01], (9, 1))
    return Exported(moving_track(steps, [happened("turn", 2, 6, turn=20)]), mm_per_px)


def drawn(exported):
    return drawing_of(exported.track, exported.units)


@pytest.mark.parametrize("mm_per_px", [None, 0.06])
def test_curves_hold_the_way_of_the_track_with_its_spans_in_its_unit(mm_per_px):
    whole = exported(2.0, 1.0, -3.0, mm_per_px)
    path, spread = whole.track.path_from_start, 1.645 * whole.track.path_deviations
    factors = [1, *whole.units.travelled(1.0, 1.0), 1]
    *curves, contact = drawn(whole).curves
    unit = whole.units.name
    assert [(curve.name, curve.unit) for curve in curves] == [
        ("turn", "deg"), ("right", unit), ("down", unit), ("depth", "mm")
    ]  # fmt: skip
    for column, curve in enumerate(curves):
        assert curve.mean == pytest.approx(factors[column] * path[:, column])
        assert curve.spread == pytest.approx(factors[column] * spread[:, column])
    assert (contact.mean == whole.track.contact).all()


def test_a_drawing_is_led_on_to_a_frame_that_is_not_settled_yet():
    whole = drawn(exported(2.0, 1.0))
    part = drawn(Exported(exported(2.0, 1.0).track.between(0, 7)))
    now = part.up_to(whole.times_s[8], whole.way[8] - whole.way[0])
    assert now.times_s == pytest.approx(whole.times_s)
    assert now.arrows == pytest.approx(whole.arrows - whole.arrows[0])
    turn, *_, contact = now.curves
    assert turn.mean == pytest.approx(whole.curves[0].mean - whole.curves[0].mean[0])
    assert (turn.spread[8], contact.mean[8]) == (turn.spread[7], contact.mean[7])


def test_the_caption_says_what_happens_now_and_just_did():
    drawing = drawn(exported())
    captions = [drawing.mark(place).lines[1] for place in range(9)]
    assert captions == ["", "", *["turn clockwise 20 deg"] * 7]


def last_frame(**way):
    """Return where arrow and hand are in the last frame: (dial, the rest below it)."""
    image = draw_mark(FRAMES[8][1], drawn(exported(**way)).mark(8))
    red, green, blue = cv2.split(image[:-CAPTION_ROWS].astype(int))
    yellow = (red > 170) & (green > 140) & (blue < 110)
    side = 2 * (DIAL_MARGIN + DIAL_PX)
    dial = yellow[:side, :side].copy()
    yellow[:side, :side] = False
    return dial, yellow


@pytest.mark.parametrize(("turn", "axis", "sign"), [(10, 1, 1), (-10, 1, -1), (20, 0, 1)])
def test_the_hand_of_the_dial_turns_as_the_object_does(turn, axis, sign):
    """After 9 frames by 90 or -90 degrees it points right or left; by 180 it points down."""
    middle = DIAL_MARGIN + DIAL_PX
    place = np.argwhere(last_frame(turn=turn)[0]).mean(axis=0)
    assert sign * (place[axis] - middle) > DIAL_PX / 3
    assert abs(place[1 - axis] - middle) < 4


@pytest.mark.parametrize(
    ("way", "axis", "sign"), [({"right": 4}, 1, 1), ({"right": -4}, 1, -1), ({"down": 4}, 0, 1)]
)
def test_the_arrow_points_where_the_contact_has_gone(way, axis, sign):
    rows, columns = 336, 448  # of the magnified frame
    place = np.argwhere(last_frame(**way)[1]).mean(axis=0) - (rows / 2, columns / 2)
    assert sign * place[axis] > 10
    assert abs(place[1 - axis]) < 3


class FullDisk:
    """A writer whose file ends where the disk was full."""

    def __init__(self, path, *rest):
        self.path, self.writer = path, WRITER(path, *rest)
        self.isOpened, self.write = self.writer.isOpened, self.writer.write

    def release(self):
        self.writer.release()
        with Path(self.path).open("r+b") as stream:
            stream.truncate(600)


WRITER = cv2.VideoWriter


def test_a_film_that_is_cut_off_is_an_error_and_what_was_there_before_stays(tmp_path, monkeypatch):
    path = tmp_path / "seen.mp4"
    path.write_bytes(b"an earlier film")
    monkeypatch.setattr(drawing.cv2, "VideoWriter", FullDisk)
    with pytest.raises(UsageError) as caught:
        write_film(path, exported(), FRAMES, 25.0)
    assert str(caught.value) == (
        f"{path} could not be written whole; free some room on the disk, or give a name on "
        f"another one."
    )
    assert [entry.name for entry in tmp_path.iterdir()] == ["seen.mp4"]
    assert path.read_bytes() == b"an earlier film"


def test_a_film_of_a_name_that_is_not_utf_8_is_written(tmp_path):
    path = tmp_path / os.fsdecode(b"m\xe9") / os.fsdecode(b"seen\xe9.mp4")
    write_film(path, exported(), FRAMES, 25.0)
    assert len(read_clip(path)) == len(FRAMES)


def test_a_film_that_is_broken_off_leaves_nothing(tmp_path):
    def broken_off():
        yield FRAMES[0]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_film(tmp_path / "seen.mp4", exported(), broken_off(), 25.0)
    assert list(tmp_path.iterdir()) == []


CLIP = turned(20)


def entities(path):
    """Return the tables that a recording holds of each entity."""
    chunks = pytest.importorskip("rerun.chunk", reason="needs rerun-sdk, of the extra rerun")
    tables = {}
    for chunk in chunks.RrdReader(path).stream():
        tables.setdefault(chunk.entity_path, []).append(chunk.to_record_batch())
    return tables


def column(tables, component):
    """Return the values of a component in the order of the frames."""
    rows = [row for table in tables for row in table.to_pylist()]
    rows = [(row["frame"], row[component]) for row in rows if row.get(component) is not None]
    return [value for _, value in sorted(rows, key=lambda row: row[0])]


def test_a_rerun_recording_holds_frames_marks_curves_events_and_the_answer(tmp_path):
    pytest.importorskip("rerun", reason="needs rerun-sdk, of the extra rerun")
    path = tmp_path / os.fsdecode(b"m\xe9") / "out.rrd"
    whole = Exported(track_of(CLIP, idle=CLIP.frames[0]), mm_per_px=0.06)
    with rerun_recording(path) as stream:
        log_track(stream, whole, CLIP)
        log_answer(stream, "Which way?", "Clockwise.", ["Tracked from frame 0 to 23."])
    tables, drawing = entities(path.rename(tmp_path / "out.rrd")), drawn(whole)
    assert len(column(tables["/camera/image"], "EncodedImage:blob")) == len(CLIP)
    hands = np.array(column(tables["/camera/turn"], "Arrows2D:vectors"))[:, 0]
    turned_deg = np.degrees(np.arctan2(hands[:, 0], -hands[:, 1]))
    assert turned_deg == pytest.approx(drawing.way[:, 0], abs=1e-3)
    names = ("/turn/deg", "/travel/right_mm", "/travel/down_mm", "/depth/mm", "/contact")
    for name, curve in zip(names, drawing.curves, strict=True):
        values = np.array(column(tables[name], "Scalars:scalars"))
        assert values[:, 0] == pytest.approx(curve.mean)
        if curve.spread is not None:
            assert values[:, 2] - values[:, 0] == pytest.approx(curve.spread)
    texts = [text for (text,) in column(tables["/events"], "TextLog:text")]
    assert len(texts) == len(drawing.bands)
    assert any(text.startswith("turn clockwise ") and " deg (" in text for text in texts)
    (text,) = tables["/answer"][0].to_pylist()[0]["TextDocument:text"]
    assert text == "**Which way?**\n\nClockwise.\n\n*Tracked from frame 0 to 23.*"


def test_a_recording_that_was_not_tracked_is_its_frames(tmp_path):
    pytest.importorskip("rerun", reason="needs rerun-sdk, of the extra rerun")
    with rerun_recording(tmp_path / "out.rrd") as stream:
        log_clip(stream, CLIP.select([3, 9]))
    rows = [row for t in entities(tmp_path / "out.rrd")["/camera/image"] for row in t.to_pylist()]
    assert sorted(row["frame"] for row in rows) == [3, 9]


def test_an_error_leaves_no_rerun_recording(tmp_path):
    pytest.importorskip("rerun", reason="needs rerun-sdk, of the extra rerun")
    with pytest.raises(RuntimeError, match="stop"), rerun_recording(tmp_path / "out.rrd"):
        raise RuntimeError("stop")
    assert list(tmp_path.iterdir()) == []


def test_without_rerun_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("geotlm_lm.core.errors.find_spec", lambda name: None)
    with (
        pytest.raises(MissingDependency, match=r"with rerun, .*'geotlm-lm\[rerun\]'"),
        rerun_recording(tmp_path / "out.rrd"),
    ):
        pass
