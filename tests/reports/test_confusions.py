import builtins
from importlib.util import find_spec

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import MissingDependency
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.confusions import (
    confusion_pictures,
    contrast,
    draw_confusions,
    ink_on,
    panels,
    shade,
    stale_pictures,
)

WORDS, FLOW = "language model, words", "optical flow + rigid fit"

needs_matplotlib = pytest.mark.skipif(
    find_spec("matplotlib") is None,
    reason="pictures need matplotlib (extra: eval)",
)


def table_of(words, flow=((5, 0, 0), (0, 5, 0)), labels=("left", "right")):
    return {
        "truths": {"left": 5, "right": 5},
        "methods": {
            WORDS: {"confusion": {"labels": list(labels), "counts": words}},
            FLOW: {"confusion": {"labels": ["left", "right"], "counts": [list(r) for r in flow]}},
            "linear probe on c": {"confusion": {"labels": [], "counts": []}},
        },
    }


TABLE = table_of([[4, 0, 0, 1], [0, 3, 2, 0], [0, 0, 0, 0]], labels=("left", "right", "press"))


@pytest.fixture
def record():
    tables = {"real x, four frames": TABLE, "real x, four frames, forwards": TABLE}
    return RunRecord("evaluate", "", 0, 1.0, {"tables": tables})


def test_panels_share_their_columns_and_count_what_no_answer_was_given_to():
    drawn = panels(TABLE)
    assert list(drawn) == [WORDS, FLOW]
    truths, answers, counts = drawn[WORDS]
    assert truths == ["left", "right"]
    assert answers == ["left", "right", "press", "no answer"]
    assert counts.tolist() == [[4, 0, 0, 1], [0, 3, 2, 0]]
    assert drawn[FLOW][2].tolist() == [[5, 0, 0, 0], [0, 5, 0, 0]]


def test_a_record_of_other_methods_shows_all_of_them():
    confusion = {"labels": ["left", "right"], "counts": [[5, 0, 0], [0, 5, 0]]}
    table = {"truths": {"left": 5, "right": 5}, "methods": {"mine": {"confusion": confusion}}}
    assert list(panels(table)) == ["mine"]


@pytest.mark.parametrize(("wrong", "shown"), [(0, 1), (1, 2)])
def test_a_probe_asked_about_all_motions_anyway_is_drawn_once(wrong, shown):
    free = {"labels": ["left", "right"], "counts": [[5, 0, 0], [0, 5, 0]]}
    asked = {"labels": ["left", "right"], "counts": [[5 - wrong, wrong, 0], [0, 5, 0]]}
    methods = {
        "linear probe on z, all motions": {"confusion": free},
        "linear probe on z": {"confusion": asked},
    }
    assert len(panels({"truths": {"left": 5, "right": 5}, "methods": methods})) == shown


def test_labels_stand_in_the_order_of_the_motions():
    labels = [str(motion) for motion in Motion]
    counts = np.hstack([np.eye(10, dtype=int), np.zeros((10, 1), int)])
    confusion = {"labels": labels[::-1], "counts": counts.tolist()}
    table = {"truths": dict.fromkeys(labels, 1), "methods": {WORDS: {"confusion": confusion}}}
    truths, answers, _ = panels(table)[WORDS]
    assert truths == answers == labels


def test_only_whole_tables_get_a_picture(record):
    assert confusion_pictures(record) == {
        "real x, four frames": "confusions/real-x-four-frames.png"
    }


@pytest.mark.parametrize("is_right", [True, False])
def test_every_number_reads_on_its_cell(is_right):
    """WCAG 2 asks a contrast of 4.5 of small text."""
    for share in np.linspace(0, 1, 101):
        colour = shade(share, is_right)
        assert contrast(ink_on(colour), colour) >= 4.5


def test_contrast_is_that_of_the_standard():
    """Its own examples: black on white 21, equal colours 1, #777777 on white 4.48."""
    assert contrast((0, 0, 0), (255, 255, 255)) == pytest.approx(21)
    assert contrast((9, 9, 9), (9, 9, 9)) == 1
    assert contrast((119, 119, 119), (255, 255, 255)) == pytest.approx(4.48, abs=0.005)


def test_right_and_wrong_differ_in_colour_and_a_rare_mistake_shows():
    assert shade(0.0, True) == shade(0.0, False) == (255, 255, 255)
    assert shade(1.0, True) != shade(1.0, False)
    assert contrast(shade(0.02, False), (255, 255, 255)) > 1.05


@needs_matplotlib
def test_a_picture_is_opaque_so_that_it_reads_on_any_page(record, tmp_path):
    (path,) = draw_confusions(record, tmp_path)
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    alpha = image[..., 3] if image.shape[-1] == 4 else np.array([255])
    assert alpha.min() == 255
    assert (image[0, 0, :3] == 255).all()
    # The colours of a right and of a wrong cell (BGR) are in it.
    for colour in (shade(0.8, True), shade(0.4, False)):
        assert (np.abs(image[..., 2::-1].astype(int) - colour).max(axis=-1) <= 1).sum() > 200


@needs_matplotlib
def test_a_picture_is_fresh_until_the_numbers_change(record, tmp_path):
    assert [path.name for path in stale_pictures(record, tmp_path)] == ["real-x-four-frames.png"]
    draw_confusions(record, tmp_path)
    assert stale_pictures(record, tmp_path) == []
    record.numbers["tables"]["real x, four frames"] = table_of([[5, 0, 0], [0, 5, 0]])
    assert len(stale_pictures(record, tmp_path)) == 1


@needs_matplotlib
def test_the_same_record_draws_the_same_bytes(record, tmp_path):
    first, again = (draw_confusions(record, tmp_path / name)[0].read_bytes() for name in ("a", "b"))
    assert first == again


def test_without_matplotlib_it_says_what_to_install(record, tmp_path, monkeypatch):
    original = builtins.__import__

    def refuse(name, *rest):
        if name.startswith("matplotlib"):
            raise ImportError(name)
        return original(name, *rest)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(MissingDependency) as caught:
        draw_confusions(record, tmp_path)
    assert str(caught.value) == (
        "pictures are drawn by matplotlib, which is not installed; run `pip install "
        "'geotlm-lm[eval]'`."
    )
