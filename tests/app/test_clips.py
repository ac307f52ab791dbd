"""What was given is opened alone, by whole frame numbers, and told by its own name."""

import cv2
import numpy as np
import pytest

from app.clips import latest_upload
from geotlm_lm import GeoTLMError
from tests.app.fakes import FakeAnswerer, load_clip


class Refusing(FakeAnswerer):
    """Refuses every recording by its name, as a model does that can see nothing in it."""

    def encode(self, clip, **_):
        raise GeoTLMError(f"{clip.name}: 100% of frame 0 is black.")


@pytest.mark.parametrize(
    ("given", "opened"),
    [
        (None, []),
        (["a.npy"], ["a.npy"]),
        (["a.npy", "b.MP4"], ["b.MP4"]),
        (["1.png", "2.PNG"], ["1.png", "2.PNG"]),
        (["1.png", "2.png", "a.npy"], ["a.npy"]),
        (["a.npy", "1.png", "2.png"], ["1.png", "2.png"]),
    ],
)
def test_of_several_recordings_the_last_is_opened(given, opened):
    assert latest_upload(given) == opened


def test_a_recording_refused_while_it_is_perceived_is_told_by_its_own_name(path):
    with pytest.raises(GeoTLMError, match="^clip.npy: 100% of frame 0 is black.$"):
        load_clip(Refusing(), path)


def test_images_that_cannot_be_read_are_told_by_their_own_names(tmp_path):
    paths = [str(tmp_path / f"{number}.png") for number in range(2)]
    for one in paths:
        (tmp_path / one).write_bytes(b"no image")
    with pytest.raises(GeoTLMError, match="^0.png: "):
        load_clip(FakeAnswerer(), paths)


@pytest.mark.parametrize(
    ("ends", "sentence"),
    [
        ((0, None), "Only one end of the span was given"),
        (("", "3"), "Only one end of the span was given"),
        ((0, 1.5), "The span was .* to .*, expected two whole numbers; "),
        (("-1", "3"), "The span was .* to .*, expected two whole numbers; "),
    ],
)
def test_a_span_that_is_none_is_refused(path, ends, sentence):
    with pytest.raises(GeoTLMError, match=f"^{sentence}"):
        load_clip(FakeAnswerer(), path, *ends)


def test_several_recordings_are_refused(path):
    sentence = "Several recordings were given; give one, or the images of one."
    with pytest.raises(GeoTLMError, match=f"^{sentence}$"):
        load_clip(FakeAnswerer(), [path] * 2)


@pytest.mark.parametrize("first_and_last", [(0, 3), (" 0", "3 ")])
def test_a_span_of_whole_numbers_is_used(path, first_and_last):
    shown = load_clip(FakeAnswerer(), path, *first_and_last)
    assert list(shown.encoded.clip.frame_numbers) == [0, 1, 2, 3]


@pytest.mark.parametrize("shape", [(6, 48, 64), (6, 48)])
def test_grey_frames_are_told_what_can_be_done_in_the_page(tmp_path, shape):
    np.save(tmp_path / "grey.npy", np.full(shape, 90, np.uint8))
    with pytest.raises(GeoTLMError, match="^grey.npy: .* the command line with --layout") as caught:
        load_clip(FakeAnswerer(), str(tmp_path / "grey.npy"))
    assert "pass --layout" not in str(caught.value)


def test_of_a_bag_with_two_cameras_one_is_opened_by_its_topic(bag):
    advice = "give it as `topic`, on the page under Details of the Ask tab"
    with pytest.raises(GeoTLMError, match=f"on 2 topics.*{advice}[.]$"):
        load_clip(FakeAnswerer(), str(bag))
    assert load_clip(FakeAnswerer(), str(bag), topic="/left").encoded.clip.recorded_frames == 4


def test_several_images_are_one_recording(tmp_path):
    paths = []
    for number in range(4):
        paths.append(str(tmp_path / f"{number}.png"))
        cv2.imwrite(paths[-1], np.full((40, 50, 3), 40 * number, np.uint8))
    clip = load_clip(FakeAnswerer(), paths).encoded.clip
    assert [int(frame.mean()) for frame in clip.frames] == [0, 40, 80, 120]
