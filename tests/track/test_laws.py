"""What holds of every track: it is one decision, whatever is read of it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.track.events import COLUMNS, EventFinder, EventKind, Moment
from geotlm_lm.track.track import Track, decided
from geotlm_lm.track.tracker import Tracker
from tests.track.recordings import recording, there_and_back
from tests.track.tracks import FPS, happened, moving_track, track_of_events

FAR = {0: 40.0, 1: 12.0, 2: 12.0, 3: 0.8}
"""Most that a stretch goes: degrees, pixels, pixels, mm."""

STEP_VARIANCE = np.diag([1e-3, 1e-3, 1e-3, 1e-4])


@st.composite
def tracks(draw) -> Track:
    """Contacts that move in stretches at any speed, with noise, and frames without between."""
    rng = np.random.default_rng(draw(st.integers(0, 2**16)))
    stretches, touched = [np.zeros((6, 4))], [False] * 6
    for _ in range(draw(st.integers(1, 7))):
        frames, is_touched = draw(st.integers(1, 30)), draw(st.integers(0, 4)) > 0
        steps = np.zeros((frames, 4))
        for column in draw(st.sets(st.sampled_from(list(FAR)), max_size=2)) if is_touched else ():
            steps[:, column] = draw(st.floats(-1, 1)) * FAR[column] / frames
        noise = rng.normal(0, 0.02, steps.shape) * [1, 1, 1, 0.1]
        stretches.append(steps + noise if is_touched else steps)
        touched += [is_touched] * frames
    steps = np.concatenate(stretches).astype(np.float32)  # as `Table` keeps them
    return tracked(steps, np.array(touched))


def tracked(steps, touched) -> Track:
    """The track of raw steps."""
    raw, finder, events = _raw(steps, touched), EventFinder(), []
    for moment in _moments(raw, touched):
        events += finder.push(moment)
    return decided(raw, events + finder.finish(), {})


def _raw(steps, touched):
    contact = np.where(touched, 0.98, 0.02)
    track = moving_track(steps, (), contact=contact)
    covariances = np.where(touched[:, None, None], STEP_VARIANCE, 0.0)
    return replace(track, covariances=covariances, radius_px=50.0 * touched)


def _moments(raw, touched):
    ways, doubts = np.cumsum(raw.twists, axis=0), np.cumsum(raw.covariances, axis=0)
    for k in range(len(raw)):
        yield Moment(k, k, k / FPS, raw.contact[k], bool(touched[k]), ways[k], doubts[k],
                     raw.radius_px[k])  # fmt: skip


def check_sums(track):
    """No way is longer than its path; a net way is the sum of what its events say."""
    for component in COMPONENTS:
        net, path = track.net(component), track.path(component)
        assert abs(net.mean) <= path.mean + 1e-6
        ways = [np.array([e.twist.turn_deg, e.twist.right_px, e.twist.down_px, e.twist.inward_mm])
                for e in track.of(component)]  # fmt: skip
        summed = sum(ways, np.zeros(4))[COLUMNS[component]]
        assert summed == pytest.approx(track.twists.sum(axis=0)[COLUMNS[component]], abs=1e-4)
        for event in track.of(component):
            assert event.amount.is_clear or event.begin == event.end
            assert event.creeps is None or event.creeps[0] <= event.begin <= event.end


def check_contact(track):
    """What happens happens in contact, and touches and releases are its ends."""
    spans = track.contacts()
    for event in track.events:
        assert any(a - 1e-9 <= event.begin_s and event.end_s <= b + 1e-9 for a, b in spans)
    touches = [event.begin_s for event in track.events if event.kind is EventKind.TOUCH]
    assert touches == [begin for begin, _ in spans]
    outside = ~track.is_touched
    assert not track.twists[outside].any()


def check_parts(track):
    """Spans that follow each other sum up to the whole."""
    if len(track) < 5:
        return
    first, last = int(track.numbers[0]), int(track.numbers[-1])
    at = int(track.numbers[len(track) // 2])
    parts = track.between(first, at), track.between(at, last)
    summed = sum(part.twists.sum(axis=0) for part in parts)
    assert summed == pytest.approx(track.twists.sum(axis=0), abs=1e-6)
    for part in parts:
        check_nets(part)


def check_nets(part):
    for component in COMPONENTS:
        assert abs(part.net(component).mean) <= part.path(component).mean + 1e-6


def check(track):
    check_sums(track)
    check_contact(track)
    check_parts(track)


@given(tracks())
@settings(max_examples=60, deadline=None)
def test_sums_contact_and_parts_are_those_of_the_events(track):
    check(track)


@pytest.mark.parametrize("component", [Component.TURN, Component.SLIDE])
@pytest.mark.parametrize("ways", [(1.0,), (1.0, -0.6), (0.3, 1.0, -1.0), (-0.2, 0.2)])
def test_a_track_played_backwards_has_the_mirrored_events(component, ways):
    column, far = (0, 30.0) if component is Component.TURN else (1, 12.0)
    steps = [np.zeros((20, 4))]
    for way in ways:
        stretch = np.zeros((15, 4))
        stretch[:, column] = way * far / 15
        steps += [stretch, np.zeros((20, 4))]
    steps = np.concatenate(steps)
    touched = np.ones(len(steps), bool)
    there, back = (
        [(e.twist.turn_deg, e.twist.right_px, e.begin, e.end) for e in one.of(component)]
        for one in (tracked(steps, touched), tracked(-steps[::-1], touched))
    )
    assert len(there) == len(ways)
    last = len(steps) - 1
    for (turn, right, begin, end), other in zip(there, back[::-1], strict=True):
        assert (-turn, -right) == pytest.approx(other[:2], abs=0.1)
        assert (begin, end) == pytest.approx((last - other[3] - 1, last - other[2] - 1), abs=2)


@pytest.mark.parametrize(
    "clip",
    [there_and_back(), recording(np.linspace(0, 4, 40), [1.0] * 40), recording([0] * 20, [0] * 20)],
    ids=["there and back", "creeping", "untouched"],
)
def test_a_stream_is_told_what_its_recording_is(clip):
    tracker, fed = Tracker(idle=there_and_back().frames[0]), []
    for k, frame in enumerate(clip.frames):
        fed += tracker.feed(frame, k / FPS)
        check_sums(tracker.so_far) if k % 20 == 19 and not tracker.so_far.radius_px[-1] else None
    track = tracker.finish()
    check(track)
    assert {id(event) for event in fed} <= {id(event) for event in track.events}


REAL_EVERY = 15
"""Of the real recordings at hand one in so many is tracked: all take a quarter hour and more."""


@pytest.mark.slow
@pytest.mark.real
def test_the_laws_hold_of_real_recordings(real):
    files = [path for path in sorted(real.rglob("clips/*")) if path.suffix in (".mov", ".avi")]
    files += sorted(real.rglob("*.mkv"))
    assert files
    for path in files[::REAL_EVERY]:
        try:
            clip = read_clip(path)
        except GeoTLMError:
            continue
        tracker = Tracker()
        for k, frame in enumerate(clip.frames):
            tracker.feed(frame, clip.second_of(k, FPS))
        check(tracker.finish())


def test_limits_are_of_the_time_in_which_it_is_held():
    lifted = happened("release", 90, 94, inward=-0.5)
    track = track_of_events([happened("touch", 10, 10), lifted])
    strengths, doubts = track.strength_grey.copy(), track.covariances.copy()
    strengths[:14] = 0.3, *[0.3] * 9, 1.0, 2.0, 3.0, 4.0
    strengths[90:] = 3.0, 2.0, 1.0, 0.6, *[0.3] * (len(track) - 94)
    doubts[[11, 12, 13, 91, 92, 93]] = 400 * np.eye(4)
    forming = replace(track, strength_grey=strengths, covariances=doubts)
    for component, limit in track.limits.items():
        assert forming.limits[component] == pytest.approx(limit, rel=0.1)
    briefly = np.where(np.arange(len(track)) < 14, forming.contact, 0.0)
    brief = replace(forming, contact=briefly, events=forming.events[:1])
    assert brief.limits[Component.SLIDE] > 20  # no frame is steady: all doubts count


def test_a_turn_hides_a_slide_where_none_is_seen():
    turned = happened("turn", 20, 40, turn=60.0), happened("touch", 10, 10)
    slid = happened("slide", 50, 60, right=9.0)
    alone, beside = (track_of_events(sorted(events, key=lambda one: one.begin))
                     for events in (turned, (*turned, slid)))  # fmt: skip
    path_px = np.radians(60.0) * alone.middle_radius_px
    assert alone.limits[Component.SLIDE] == pytest.approx(0.16 * path_px, rel=0.05)
    assert beside.limits[Component.SLIDE] < 2
