"""Other cameras: what each does to pixels, and the page made of the answers."""

import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.record import RunRecord
from geotlm_lm.experiments.methods import GENERATED
from geotlm_lm.experiments.other_cameras import (
    AS_RECORDED,
    METHODS,
    Camera,
    bent,
    cameras,
    coloured,
    cropped,
    darker_at_the_corners,
    other_cameras,
    toned,
    turned,
    turns,
    zoomed,
)
from geotlm_lm.reports import cameras as page
from tests.answering.scripted import answerer_saying, feeling
from tests.experiments.test_how_far import recordings
from tests.tiny_bundle import tiny_bundle

RNG = np.random.default_rng(0)
IMAGE = RNG.integers(60, 190, (48, 64, 3)).astype(np.uint8)


def spot(x, y, rows=49, columns=65):
    """A black image with one bright pixel."""
    image = np.zeros((rows, columns, 3), np.uint8)
    image[y, x] = 255
    return image


def brightest(image):
    """Return (x, y) of the brightest pixel."""
    y, x = np.unravel_index(int(image[..., 0].argmax()), image.shape[:2])
    return int(x), int(y)


def test_every_camera_gives_pictures_and_leaves_the_number_of_frames():
    clip = Clip(np.stack([IMAGE] * 3), background=IMAGE // 2)
    for camera in cameras().values():
        shown = camera(clip, np.random.default_rng(0))
        assert shown.frames.shape[0] == 3
        assert shown.background.shape == shown.frames.shape[1:]
    same = cameras()[AS_RECORDED](clip, np.random.default_rng(0))
    assert np.array_equal(same.frames, clip.frames)
    assert Camera()(Clip(clip.frames), np.random.default_rng(0)).background is None


def test_a_camera_askew_turns_the_picture_clockwise_as_drawn():
    # What stands right of the middle, (32, 24), comes to stand below it: x turns towards y.
    assert brightest(turned(90.0, spot(52, 24))) == (32, 44)


def test_a_nearer_camera_shows_it_further_from_the_middle():
    assert brightest(zoomed(2.0, spot(36, 22))) == (40, 20)
    assert cropped(0.5, IMAGE).shape == (24, 32, 3)
    assert np.array_equal(cropped(0.5, IMAGE), IMAGE[12:36, 16:48])


def test_a_lens_moves_what_lies_off_the_middle_and_not_the_middle():
    assert brightest(bent(0.2, spot(32, 24))) == (32, 24)
    # A point three quarters out comes from 0.75 * (1 + 0.2 * 0.75^2) = 0.834 of the half width.
    x, y = brightest(bent(0.2, spot(32 + round(0.834375 * 32), 24)))
    assert (x, y) == (32 + 24, 24)
    assert brightest(bent(-0.15, spot(56, 24)))[0] > 56


def test_tones_and_colours_change_as_they_are_named():
    assert np.array_equal(toned(lambda v: v, IMAGE), IMAGE)
    assert np.array_equal(toned(lambda v: 1 - v, IMAGE), 255 - IMAGE)
    assert np.array_equal(coloured(1.0, IMAGE), IMAGE)
    assert np.ptp(coloured(0.0, IMAGE), axis=-1).max() == 0
    flat = np.full((49, 65, 3), 200, np.uint8)
    dark = darker_at_the_corners(flat)
    assert (dark[24, 32, 0], dark[0, 0, 0], dark[-1, -1, 0]) == (200, 80, 80)


def test_a_shaking_camera_moves_frames_apart_and_a_flickering_one_lights_them_apart():
    clip = Clip(np.stack([IMAGE] * 4), background=IMAGE)
    shaken = Camera(shaking_px=2.0)(clip, np.random.default_rng(1))
    assert all(not np.array_equal(frame, IMAGE) for frame in shaken.frames)
    assert np.array_equal(shaken.background, IMAGE)
    lit = Camera(flicker=0.03)(clip, np.random.default_rng(1)).frames.mean(axis=(1, 2, 3))
    share = lit / IMAGE.mean() - 1
    assert 0.005 < np.abs(share).max() < 0.031
    assert np.ptp(share) > 0.005


def test_windows_of_turns_alone_are_taken_evenly(tmp_path):
    sets = turns(recordings(tmp_path), most=5)
    # The table holds one turn, whose window is also played backwards, and slides beside it.
    [(title, cases)] = sets.items()
    assert title == f"real {tmp_path.name} rotation"
    assert [case.motion.value for case in cases] == ["clockwise", "counterclockwise"]


def test_a_folder_without_turns_is_refused(tmp_path):
    folder = recordings(tmp_path)
    (folder / "windows.csv").write_text(
        "clip,first_frame,last_frame,direction\nclips/a.npy,2,8,left\n"
    )
    with pytest.raises(UnreadableClip) as caught:
        other_cameras(answerer_saying(tiny_bundle(), {}), folder, clips=2, seed=0)
    assert str(caught.value) == (
        f"{folder}: holds no labelled turns, expected windows.csv with clockwise or "
        f"counterclockwise windows; give the folder of such recordings."
    )


def test_the_record_its_page_and_its_sentence_hold_every_camera(tmp_path):
    shown_by = {name: cameras()[name] for name in (AS_RECORDED, "gamma 1.6", "cold colours")}
    answerer = feeling(tiny_bundle(), "clockwise")
    record = other_cameras(answerer, recordings(tmp_path), clips=4, seed=0, shown_by=shown_by)
    assert tuple(page.METHODS) == METHODS
    assert page.AS_RECORDED == AS_RECORDED
    [(title, rows)] = record.numbers.items()
    assert [row["camera"] for row in rows] == list(shown_by)
    for row in rows:  # one of the two windows, which are each other's mirror in time
        assert (row["clips"], row["wrong"], row[GENERATED]) == (2, 0.5, 0.5)
    record.save(tmp_path / "cameras.json")
    read = RunRecord.load(tmp_path / "cameras.json")
    assert page.cameras_page(read).count("\n| ") == 2 + 3
    assert f"- {title}, 2 clips: words are right on " in page.cameras_headline(read)
    assert "as 2 other cameras show it" in page.cameras_headline(read)


def test_the_sentence_names_the_cameras_under_which_words_fail_most():
    rows = [
        dict.fromkeys(METHODS, share) | {"camera": name, "clips": 10, "wrong": 0.0}
        for name, share in ((AS_RECORDED, 1.0), ("a", 0.9), ("b", 0.5), ("c", 0.7), ("d", 0.6))
    ]
    record = RunRecord("cameras", "command", 0, 1.0, {"turns": rows})
    said = page.cameras_headline(record)
    assert "on 1.000 as recorded and on 0.675 on average" in said
    assert "(least: b 0.500, d 0.600, c 0.700)" in said
