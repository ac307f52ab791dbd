"""What is watched on the Live tab: as the command tracks it, each visitor by itself."""

from types import SimpleNamespace

import numpy as np
import pytest

from app import live_tab as live
from app.live_tab import (
    NOTHING,
    NOW_S,
    LiveSession,
    LiveTalk,
    follow_camera,
    stop,
    wait_for,
    watch_recording,
)
from geotlm_lm import GeoTLMError
from geotlm_lm.core.errors import Unsure
from tests.app.fakes import READ, FakeAnswerer
from tests.track.recordings import there_and_back


@pytest.fixture
def clock(monkeypatch):
    """The camera's: 0.04 s go by from frame to frame."""
    ticks = iter(1e6 + 0.04 * number for number in range(1000))
    monkeypatch.setattr(live, "time", SimpleNamespace(monotonic=lambda: next(ticks)))


def stages(steps):
    return [step["stage"] for step in steps if step.get("stage")]


def followed(frames, watched):
    """Return what is told of each frame of a camera."""
    told = [follow_camera(FakeAnswerer(), one, watched) for one in frames]
    return [step for step in told if step]


def events_of(told):
    return [event for lane in told["timeline"]["lanes"] for event in lane["events"]]


def test_a_recording_is_watched_to_its_end(tmp_path):
    clip = there_and_back()
    np.savez(tmp_path / "clip.npz", frames=clip.frames, fps=clip.fps)
    told = stages(watch_recording(FakeAnswerer(), str(tmp_path / "clip.npz"), LiveSession()))
    last, events = told[-1], events_of(told[-1])
    (turn,) = (one for one in events if one["text"].startswith("clockwise "))
    assert (turn["begin"], turn["end"]) == pytest.approx((1.0, 1.8), abs=0.25)
    assert float(turn["text"].split()[1].removesuffix("°")) == pytest.approx(30, rel=0.25)
    assert (events[0]["kind"], last["live"], last["window"]) == ("touch", False, [0.0, 4.16])
    assert last["about"] == "idle gel learnt · 105 frames"
    assert {one["stream"] for one in told} == {last["stream"]}
    counts = [len(events_of(one)) for one in told]
    assert any(0 < count < len(events) for count in counts)  # events come as they are over
    ends = [one["timeline"]["x"][-1] for one in told]
    assert ends == sorted(ends)
    assert all(one["live"] and one["picture"]["image"] for one in told[:-1])


def test_the_window_grows_and_then_rolls(frames, monkeypatch, clock):
    monkeypatch.setattr(live, "WINDOW_S", 0.8)
    monkeypatch.setattr(live, "FIRST_WINDOW_S", 0.4)
    told = [one["timeline"]["x"] for one in stages(followed(frames, LiveSession()))]
    assert told[5][0] == 0
    assert told[-1][0] == pytest.approx(39 * 0.04 - 0.8, abs=0.05)
    windows = [one["window"] for one in stages(followed(frames[:30], LiveSession()))]
    assert windows[0] == [0.0, 0.4]
    assert windows[-1] == pytest.approx([29 * 0.04 - 0.8, 29 * 0.04])


def test_a_picture_shows_where_the_gel_has_changed(frames, clock):
    told = stages(followed(frames, LiveSession()))
    assert told[0]["picture"]["outline"] == []  # the idle gel is not known yet
    assert told[0]["idle"] is None
    assert sum(one["idle"] is not None for one in told) == 1
    assert told[10]["picture"]["outline"] == []
    assert len(told[-1]["picture"]["outline"]) == 1


def test_a_recording_without_an_untouched_gel_says_so_at_its_end(frames, tmp_path):
    np.savez(tmp_path / "clip.npz", frames=np.stack(frames[:4]), fps=25.0)
    told = stages(watch_recording(FakeAnswerer(), str(tmp_path / "clip.npz"), LiveSession()))
    assert [lane["events"] for lane in told[-1]["timeline"]["lanes"]] == [[]] * 4
    assert "No untouched gel was seen" in told[-1]["notes"][0]
    assert not any(lane["curves"] or lane["is_known"] for lane in told[-1]["timeline"]["lanes"])


def test_a_camera_is_followed_frame_by_frame_and_each_session_by_itself(frames):
    one, other = LiveSession(), LiveSession()
    followed(frames[:6], one)
    (told,) = stages(followed(frames[:1], other))
    assert (one.stream.count, other.stream.count) == (6, 1)
    assert told["about"] == "learning the idle gel · 1 frames"


def test_blank_pictures_before_a_cameras_first_one_begin_nothing(frames):
    watched = LiveSession()
    assert followed([np.zeros_like(frames[0])] * 2, watched) == []
    assert watched.stream is None
    assert len(followed(frames[:3], watched)) == 3


def test_a_camera_of_another_size_is_followed_from_its_beginning(frames):
    watched = LiveSession(mm_per_px=0.05)
    followed(frames[:1], watched)
    (step,) = followed([frames[1][:60, :80]], watched)
    assert (watched.stream.count, watched.mm_per_px, step["mm_per_px"]) == (1, None, 0)


def test_a_camera_that_goes_on_does_not_replace_a_recording(frames, touch_path, monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(live, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    watched = LiveSession()
    followed(frames[:2], watched)
    list(watch_recording(FakeAnswerer(), str(touch_path), watched))
    assert followed(frames[:1], watched) == []
    clock[0] += 3  # it was stopped, and started again
    assert len(followed(frames[:1], watched)) == 1


def test_a_recording_that_fails_is_told_by_its_own_name_and_nothing_stays_of_the_one_before(
    tmp_path,
):
    with pytest.raises(GeoTLMError, match="^No recording was given; upload one first.$"):
        next(watch_recording(FakeAnswerer(), None, LiveSession()))
    (tmp_path / "broken.npy").write_bytes(b"no recording")
    steps = watch_recording(FakeAnswerer(), str(tmp_path / "broken.npy"), LiveSession())
    assert next(steps) == NOTHING
    with pytest.raises(GeoTLMError, match="^broken.npy: "):
        next(steps)


def test_nothing_is_left_and_a_camera_followed_anew_once_everything_was_emptied(frames, touch_path):
    watched = LiveSession()
    steps = watch_recording(FakeAnswerer(), str(touch_path), watched)
    while not next(steps).get("stage"):
        pass
    assert list(stop(watched)) == [NOTHING]
    assert list(steps) == [NOTHING]
    followed(frames[:3], watched)
    list(stop(watched))
    followed(frames[3:4], watched)
    assert watched.stream.count == 1


def answers(watched, question, facts=(), mm_per_px=0):
    talk = LiveTalk(FakeAnswerer())
    return list(talk.ask(question, watched, list(facts), mm_per_px))


def test_a_question_is_about_what_was_seen_by_then_and_the_conversation_goes_on(
    frames, clock, monkeypatch
):
    monkeypatch.setitem(READ, "Which way does it go?", "way all")
    watched = LiveSession()
    with pytest.raises(GeoTLMError, match="^Nothing was watched yet; start the camera or a rec"):
        answers(watched, "Which way does it go?")
    followed(frames[:30], watched)
    assert answers(watched, "Which way does it go?")[-1]["chat"]["exchanges"][-1]["answer"]
    session = watched.stream.shown().session
    assert session.encoded.recording is None
    followed(frames[30:], watched)
    told = answers(watched, "Are you sure?")[-1]
    assert watched.stream.shown().session is session
    assert len(session.history) == 2
    assert "stage" not in told
    list(LiveTalk(FakeAnswerer()).forget(watched, []))
    assert watched.stream.shown().session is not session


def test_a_pixels_size_is_told_of_all_that_is_watched(frames, clock):
    watched = LiveSession()
    followed(frames, watched)
    told = answers(watched, "0.05 mm per pixel. Which way?")[-1]
    assert told["stage"]["timeline"]["lanes"][2]["unit"] == "mm"
    assert told["mm_per_px"] == watched.mm_per_px == 0.05
    (told,) = LiveTalk(FakeAnswerer()).resize(watched, 0)
    assert told["stage"]["timeline"]["lanes"][2]["unit"] == "px"
    with pytest.raises(GeoTLMError, match="^A pixel of 60 mm was given"):
        list(LiveTalk(FakeAnswerer()).resize(watched, 60))


@pytest.mark.parametrize(("fitting", "kept"), [(20, 20), (0, live.LEAST_KEPT)])
def test_frames_that_are_kept_are_bounded_and_enough_for_a_question(
    frames, monkeypatch, clock, fitting, kept
):
    monkeypatch.setattr(live, "KEPT_BYTES", fitting * frames[0].nbytes)
    watched = LiveSession()
    for count in range(25, 41):
        followed(frames[watched.stream.count if watched.stream else 0 : count], watched)
        assert watched.stream.shown().encoded.track is not None
    assert len(watched.stream._kept) <= kept


def test_an_answer_about_what_is_watched_no_more_is_not_shown(frames, clock, monkeypatch):
    monkeypatch.setitem(READ, "Which way does it go?", "way all")
    watched, talk = LiveSession(), LiveTalk(FakeAnswerer())
    followed(frames, watched)
    session = watched.stream.shown().session
    ask = session.ask
    session.ask = lambda question: (list(stop(watched)), ask(question))[1]
    (pending,) = talk.ask("Which way does it go?", watched, [], 0)
    assert pending["chat"]["exchanges"] == []


def waiting(watched, text):
    (told,) = wait_for(FakeAnswerer(), text, watched, [], 0)
    return told["stage"]


def test_the_moment_from_which_on_a_condition_holds_is_marked(tmp_path):
    clip, watched = there_and_back(), LiveSession()
    np.savez(tmp_path / "clip.npz", frames=clip.frames, fps=clip.fps)
    text = "it has turned 20 degrees clockwise"
    assert waiting(watched, text)["condition"].startswith("Will wait for this: it turns clockwise")
    told = stages(watch_recording(FakeAnswerer(), str(tmp_path / "clip.npz"), watched))
    assert told[0]["condition"].startswith("Waiting for this: ")
    assert told[0]["marks"] == []
    (moment,) = told[-1]["marks"]
    assert 1.2 < moment < 1.9  # it turns by 30 degrees from 1 to 1.8 s
    assert told[-1]["condition"].startswith(f"Noticed at {moment:.2f} s: it turns clockwise")
    assert waiting(watched, " ")["marks"] == []
    # Stated when all is over, it is marked where it held: by all that was seen, no later than live.
    after = waiting(watched, text)
    assert 1.0 < after["marks"][0] <= moment
    assert after["condition"].startswith("Noticed at 1.")
    kept = watched.condition
    with pytest.raises(GeoTLMError, match="expected something that holds or does not"):
        waiting(watched, "Which way does it go?")
    assert watched.condition is kept  # the one before is still waited for
    still = "Still watched for, n" + after["condition"].removeprefix("N")
    assert watched.stream.stage()["condition"] == still
    assert waiting(watched, text)["condition"] == after["condition"]


def test_what_a_refused_condition_most_likely_means_is_offered(monkeypatch):
    answerer, watched = FakeAnswerer(), LiveSession()
    read, text = answerer.condition, "it has turned 20 degrees clockwise"
    assert waiting(watched, text)

    def condition(words, **named):
        if words in guesses:
            raise Unsure("This was not surely understood.", guesses[words])
        return read(words, **named)

    guesses = {"it goes round": text, "banana": "plum", "plum": "banana"}
    monkeypatch.setattr(answerer, "condition", condition)
    for words, label in (("it goes round", f"Mark: {text}"), ("banana", "")):
        steps = wait_for(answerer, words, watched, [], 0)
        offered = next(steps)
        assert offered["guess"].visible == bool(label)
        assert label in (offered["guess"].value, "")
        assert offered["stage"]["condition"].startswith("Still watched for: it turns clockwise")
        with pytest.raises(Unsure):
            next(steps)


def test_what_happens_now_is_told_of_the_last_moments(tmp_path, clock):
    watched = LiveSession()
    followed(there_and_back().frames[:70], watched)
    track = watched.stream.shown(is_now=True).encoded.track
    assert track.times_s[-1] == pytest.approx(69 * 0.04)
    assert 0 <= track.times_s[0] - (69 * 0.04 - NOW_S) < 0.04 + 1e-9
    followed(there_and_back().frames[70:80], watched)
    later = watched.stream.shown(is_now=True).encoded.track
    assert len(later) == len(track)
    assert later.times_s[-1] == pytest.approx(79 * 0.04)
    assert watched.stream.shown().encoded.track.times_s[0] == 0


@pytest.mark.parametrize("step_s", [0.04, 0.1, 0.3, 1.0])
def test_what_happens_now_is_told_however_slow_the_camera_and_few_the_frames_kept(
    monkeypatch, step_s
):
    ticks = iter(1e6 + step_s * number for number in range(1000))
    monkeypatch.setattr(live, "time", SimpleNamespace(monotonic=lambda: next(ticks)))
    monkeypatch.setattr(live, "KEPT_BYTES", 0)
    watched, frames = LiveSession(), there_and_back().frames
    followed(frames[:2], watched)
    with pytest.raises(GeoTLMError):  # one sentence
        watched.stream.shown(is_now=True)
    for begin in range(2, 102):
        followed(frames[begin : begin + 1], watched)
        if begin > 30:
            shown = watched.stream.shown(is_now=True)
            assert len(shown.encoded.clip) >= 2
            assert shown.encoded.clip.frame_numbers[-1] == begin
            numbers = [number for number, _ in watched.stream._kept]
            assert numbers == sorted(set(numbers))
            assert numbers[-5:] == list(range(begin - 4, begin + 1))


@pytest.mark.parametrize(
    ("question", "of_all"),
    [
        ("How far does it turn now?", False),
        ("How far has it turned by now?", True),
        ("And up to now, how far did it turn?", True),
        ("How far has it turned until now?", True),
    ],
)
def test_what_happened_by_now_is_told_of_all_that_was_seen(clock, monkeypatch, question, of_all):
    monkeypatch.setitem(READ, question, "net turn")
    watched = LiveSession()
    followed(there_and_back().frames[:60], watched)
    answers(watched, question)
    track = watched.stream.session.encoded.track
    assert (track.times_s[0] == 0) == of_all


def test_a_question_is_about_what_goes_on_as_well(clock):
    watched = LiveSession()
    followed(there_and_back().frames[:38], watched)  # it turns yet
    seen = watched.stream.shown().encoded.track
    assert seen.times_s[-1] == pytest.approx(37 * 0.04)
    assert seen.net_twist.turn_deg > 5
    assert not events_of(watched.stream.stage())[1:]  # drawn is what is over


def test_nothing_is_answered_before_an_untouched_gel_was_seen(frames, clock):
    watched = LiveSession()
    followed(frames[:3], watched)
    with pytest.raises(GeoTLMError, match="No untouched gel was seen yet"):
        watched.stream.shown()
