"""What a press is believed to do besides has to turn round with the clip."""

from dataclasses import replace

import pytest

from geotlm_lm.answering import Answerer, perceiving
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.track.tracker import track_of
from tests.answering.scripted import believed, recording
from tests.track.recordings import there_and_back


@pytest.fixture
def believing(bundle, monkeypatch):
    """Return what makes the belief of a clip from one of each time it is perceived."""
    seen, encode = [], bundle.model.backbone.encode
    watched = lambda clips: seen.append(clips[0].frame_numbers) or encode(clips)  # noqa: E731
    monkeypatch.setattr(bundle.model.backbone, "encode", watched)

    def believe(*told):
        told = list(told)
        monkeypatch.setattr(perceiving, "believed", lambda *_, **__: told.pop(0))
        seen.clear()
        belief = Answerer(bundle).encode(recording()).belief
        assert told == []
        return belief, list(seen)

    return believe


def test_what_turns_round_with_a_press_is_believed_and_what_does_not_is_not(believing):
    press = believed("press", "clockwise")
    belief, seen = believing(press, believed("release", "counterclockwise"))
    assert seen == [(0, 1, 2, 3), (3, 2, 1, 0)]
    assert belief.moves(Component.TURN) == pytest.approx(press.moves(Component.TURN))
    belief, _ = believing(press, believed("release", "clockwise"))
    assert belief.moves(Component.TURN) < 0.5
    assert belief.moves(Component.PRESS) == press.moves(Component.PRESS)
    assert belief.way(Component.PRESS) is Motion.PRESS
    assert belief.mean.turn_deg == pytest.approx(0.0)


@pytest.mark.parametrize("ways", [("press",), ("clockwise", "left"), ("still",)])
def test_no_other_clip_is_perceived_twice(believing, ways):
    _, seen = believing(believed(*ways, contact=1.0))
    assert seen == [(0, 1, 2, 3)]


def test_too_few_frames_do_not_tell_whether_pictures_show_how_far(bundle, monkeypatch):
    def unread(bundle, encoded):
        belief = believed("clockwise", share=0.9)
        return replace(belief, readable=dict.fromkeys(belief.readable, False))

    monkeypatch.setattr(perceiving, "belief_of", unread)
    answerer, clip = Answerer(bundle), there_and_back()
    track = track_of(clip)
    assert track.of(Component.TURN)
    ends = (0, 1, 2, len(clip) - 3, len(clip) - 2, len(clip) - 1)
    for kept, is_readable in ((range(len(clip)), False), (ends, True)):
        encoded = answerer.encode(clip.select(list(kept)), track=track)
        assert encoded.track.is_readable(Component.TURN) is is_readable
        assert encoded.belief.readable[Component.TURN] is is_readable
