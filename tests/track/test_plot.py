"""The figure of a track: rows that occur, words as words, labels apart, the same bytes again."""

import re
import zlib

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="plots need matplotlib (extra: track)")

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.twist import Component
from geotlm_lm.track import plot as plots
from geotlm_lm.track.export import Exported
from geotlm_lm.track.plot import DPI, plot, plot_png
from tests.track.tracks import happened, track_of_events

TOUCH, PRESS = happened("touch", 5, 5), happened("press", 5, 10, inward=0.4)
TURN, BACK = happened("turn", 20, 40, turn=30), happened("turn", 45, 50, turn=-12)
SLIDE = happened("slide", 60, 80, right=-9)
HELD, SLIP = happened("stick", 10, 20), happened("slip", 20, 40, turn=30, of="turn")
RELEASE = happened("release", 100, 104, inward=-0.4)


def drawn(*events, ending=".svg", **more):
    return plot(Exported(track_of_events(events)), ending, in_frames=False, **more)


def words(svg):
    """Return the texts of a figure."""
    return re.findall(r"<text[^>]*>([^<]*)</text>", svg.decode())


def rows(texts):
    names = ("turn (°)", "slide", "depth", "contact", "grip")
    return [name for name in names if name in texts]


@pytest.mark.parametrize(
    ("events", "expected"),
    [
        ((TOUCH, TURN, RELEASE), ["turn (°)", "depth", "contact"]),
        ((TOUCH, SLIDE), ["slide", "contact"]),
        ((TOUCH, PRESS, HELD, SLIP, TURN), ["turn (°)", "depth", "contact", "grip"]),
        ((), ["contact"]),
    ],
)
def test_only_the_rows_that_occur_are_drawn(events, expected):
    assert rows(words(drawn(*events))) == expected


def test_events_limit_units_and_title_are_words_in_the_figure():
    texts = words(drawn(TOUCH, PRESS, TURN, BACK, SLIDE, RELEASE, title="a $key$.mov"))
    expected = {"↻ 30°", "↺ 12°", "touch", "press 0.4 mm", "release 0.4 mm", "time (s)"}
    assert expected <= set(texts)
    assert {"a $key$.mov (5.0 s, 125 frames)", "(px)", "detection limit", "right"} <= set(texts)


def test_a_pdf_holds_letters_and_a_png_is_a_column_wide():
    pdf, png = drawn(TOUCH, TURN, ending=".pdf"), drawn(TOUCH, TURN, ending=".png")
    assert pdf.startswith(b"%PDF")
    assert b"/FontDescriptor" in pdf
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL)
    assert any(b" Tf" in _inflated(stream) for stream in streams)
    assert int.from_bytes(png[16:20]) == pytest.approx(89 / 25.4 * DPI, abs=2)
    exported = Exported(track_of_events([TOUCH, TURN]))
    assert plot_png(exported, in_frames=False) == png


def _inflated(stream):
    try:
        return zlib.decompress(stream)
    except zlib.error:
        return b""


@pytest.mark.parametrize("ending", [".svg", ".pdf"])
def test_the_same_track_gives_the_same_file(ending):
    assert drawn(TOUCH, TURN, ending=ending) == drawn(TOUCH, TURN, ending=ending)


def test_labels_do_not_overlap_and_stay_inside_however_many_there_are():
    events = [happened("turn", at, at + 2, turn=10 + at) for at in range(0, 120, 3)]
    exported = Exported(track_of_events([TOUCH, *events]))
    with plots._settings():
        figure = plots._figure(exported, in_frames=True, title="")
        labels = [text for text in figure.texts if text.get_text().startswith("↻")]
        boxes = [text.get_window_extent() for text in labels]
    assert 8 <= len(labels) < len(events)
    assert not any(a.overlaps(b) for place, a in enumerate(boxes) for b in boxes[place + 1 :])
    assert all(box.x0 >= 0 and box.x1 <= figure.bbox.x1 for box in boxes)
    assert "↻ 127°" in [text.get_text() for text in labels]  # the largest has its label


def test_the_band_about_zero_is_the_limit_that_totals_state():
    exported = Exported(track_of_events([TOUCH, TURN, SLIDE]), 0.06)
    limits, totals = exported.limits(), exported.totals()
    assert totals["turn_limit"] == round(limits[Component.TURN], 3)
    assert totals["slide_limit"] == round(limits[Component.SLIDE], 3)
    with plots._settings():
        figure = plots._figure(exported, in_frames=False, title="")
    (band,) = (patch for patch in figure.axes[0].patches if patch.get_label() == "detection limit")
    edges = band.get_extents().transformed(figure.axes[0].transData.inverted())
    assert np.allclose([edges.y0, edges.y1], [-limits[Component.TURN], limits[Component.TURN]])


def test_another_ending_is_refused():
    with pytest.raises(UsageError) as caught:
        drawn(TOUCH, ending=".jpg")
    assert str(caught.value) == (
        "A plot was to end in .jpg, expected .png or .svg or .pdf; give one of these endings."
    )
