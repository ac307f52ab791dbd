"""A drawing of a stream: whole or not there, and the learned shear in its own way and place."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import torch

from geotlm_lm.backbone.view import View
from geotlm_lm.core.errors import UsageError
from geotlm_lm.live import film
from geotlm_lm.live.film import Film

FRAME = np.full((60, 80, 3), (200, 20, 60), np.uint8)


def drawn(path, count=9):
    film_ = Film(path, 25.0)
    for _ in range(count):
        film_.add(FRAME, [], None)
    return film_


def test_it_appears_with_every_frame_once_it_is_closed(tmp_path):
    path = tmp_path / "new" / "seen.mp4"
    film_ = drawn(path)
    assert not path.exists()
    film_.close()
    assert [one.name for one in path.parent.iterdir()] == ["seen.mp4"]
    capture = cv2.VideoCapture(str(path))
    assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == 9
    is_read, image = capture.read()
    assert is_read
    red, green, blue = image[..., ::-1][: image.shape[0] // 2].mean(axis=(0, 1))
    assert red > 150 > 100 > max(green, blue)


def test_nothing_is_written_of_a_stream_without_frames(tmp_path):
    Film(tmp_path / "seen.mp4", 25.0).close()
    assert list(tmp_path.iterdir()) == []


class FullDisk:
    """A writer whose file ends where the disk was full."""

    def __init__(self, path, *rest):
        self.path, self.writer = path, WRITER(path, *rest)
        self.isOpened, self.write = self.writer.isOpened, self.writer.write

    def release(self):
        self.writer.release()
        with open(self.path, "r+b") as stream:
            stream.truncate(600)


WRITER = cv2.VideoWriter


def test_one_that_is_cut_off_is_told_and_what_was_there_before_stays(tmp_path, monkeypatch):
    path = tmp_path / "seen.mp4"
    path.write_bytes(b"an earlier film")
    monkeypatch.setattr(film.cv2, "VideoWriter", FullDisk)
    with pytest.raises(UsageError) as caught:
        drawn(path).close()
    assert str(caught.value) == (
        f"--draw: {path} could not be written whole; free some room on the disk, or give a name on "
        f"another one."
    )
    assert [one.name for one in tmp_path.iterdir()] == ["seen.mp4"]
    assert path.read_bytes() == b"an earlier film"


def test_a_place_that_cannot_be_written_is_told(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(OSError, match="file"):
        Film(tmp_path / "file" / "seen.mp4", 25.0)


@pytest.mark.parametrize(
    ("step", "axis", "sign"), [((1, 0), 0, 1), ((-1, 0), 0, -1), ((0, 1), 1, 1)]
)
def test_an_arrow_goes_the_way_of_the_shear(tmp_path, step, axis, sign):
    field = 5 * torch.tensor(step, dtype=torch.float32).expand(1, 14, 14, 2)
    mask = torch.zeros(1, 14, 14)
    mask[0, 4, 9] = 1
    geometry = SimpleNamespace(shear_change=field, mask=mask)
    perceived = SimpleNamespace(perception=SimpleNamespace(geometry=geometry), view=View())
    film = Film(tmp_path / "seen.mp4", 25.0)
    for _ in range(3):
        film.add(np.full((224, 224, 3), 90, np.uint8), [], perceived)
    film.close()
    blue, green, red = cv2.split(cv2.VideoCapture(str(tmp_path / "seen.mp4")).read()[1].astype(int))
    yellow = (red > 170) & (green > 140) & (blue < 110)
    assert yellow[400:].any()  # the legend's arrow
    rows, columns = np.nonzero(yellow[:400])
    tail = (9.5 * 32, 4.5 * 32)  # the picture is twice as large
    middle = columns.mean(), rows.mean()
    assert sign * (middle[axis] - tail[axis]) > 8
    assert abs(middle[1 - axis] - tail[1 - axis]) < 3
