"""A drawing of a track: whole or not there, its dial and arrow the way the object goes."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.track import film
from geotlm_lm.track.export import Exported
from geotlm_lm.track.film import DIAL_MARGIN, DIAL_PX, draw_motion, write_film
from tests.track.recordings import frame
from tests.track.tracks import happened, moving_track

FRAMES = [(number, frame(seed=number)) for number in range(9)]


def exported(count=9, turn=0.0, right=0.0, down=0.0):
    steps = np.tile([turn, right, down, 0.0], (count, 1))
    return Exported(moving_track(steps, [happened("turn", 2, 6, turn=20)]))


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


def test_one_that_is_cut_off_is_told_and_what_was_there_before_stays(tmp_path, monkeypatch):
    path = tmp_path / "seen.mp4"
    path.write_bytes(b"an earlier film")
    monkeypatch.setattr(film.cv2, "VideoWriter", FullDisk)
    with pytest.raises(UsageError) as caught:
        write_film(path, exported(), FRAMES, 25.0)
    assert str(caught.value) == (
        f"{path} could not be written whole; free some room on the disk, or give a name on "
        f"another one."
    )
    assert [one.name for one in tmp_path.iterdir()] == ["seen.mp4"]
    assert path.read_bytes() == b"an earlier film"


def test_one_of_a_name_that_is_not_utf_8_is_written(tmp_path):
    path = tmp_path / os.fsdecode(b"m\xe9") / os.fsdecode(b"seen\xe9.mp4")
    write_film(path, exported(), FRAMES, 25.0)
    assert os.listdir(path.parent) == [path.name]
    assert len(read_clip(path)) == len(FRAMES)


def test_a_film_that_is_broken_off_leaves_nothing(tmp_path):
    def broken_off():
        yield FRAMES[0]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_film(tmp_path / "seen.mp4", exported(), broken_off(), 25.0)
    assert list(tmp_path.iterdir()) == []


def drawn(exported):
    """The last frame."""
    return draw_motion(FRAMES[8][1], exported.path[8], exported.units)


def yellow(image):
    red, green, blue = cv2.split(image.astype(int))
    return (red > 170) & (green > 140) & (blue < 110)


@pytest.mark.parametrize(("turn", "axis", "sign"), [(10, 1, 1), (-10, 1, -1), (20, 0, 1)])
def test_the_hand_of_the_dial_turns_as_the_object_does(turn, axis, sign):
    """After 9 frames by 90 or -90 degrees it points right or left; by 180 it points down."""
    middle = DIAL_MARGIN + DIAL_PX
    image = drawn(exported(turn=turn))[: 2 * middle, : 2 * middle]
    place = np.argwhere(yellow(image)).mean(axis=0)
    assert sign * (place[axis] - middle) > DIAL_PX / 3
    assert abs(place[1 - axis] - middle) < 4


@pytest.mark.parametrize(
    ("way", "axis", "sign"), [({"right": 4}, 1, 1), ({"right": -4}, 1, -1), ({"down": 4}, 0, 1)]
)
def test_the_arrow_points_where_the_contact_has_gone(way, axis, sign):
    image = drawn(exported(**way))
    rows, columns = 336, 448  # of the magnified frame
    seen = yellow(image)
    seen[: 2 * (DIAL_MARGIN + DIAL_PX), : 2 * (DIAL_MARGIN + DIAL_PX)] = False
    place = np.argwhere(seen).mean(axis=0) - (rows / 2, columns / 2)
    assert sign * place[axis] > 10
    assert abs(place[1 - axis]) < 3


def test_the_caption_tells_what_happens_now_and_just_did():
    track, units = exported().track, exported().units
    told = [
        film.caption(film.going_on(track.events, place, place / 25), units) for place in range(9)
    ]
    assert told == ["", "", *["turn clockwise 20 deg"] * 7]
