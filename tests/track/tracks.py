"""Tracks that are written down, for what is told of them."""

import numpy as np

from geotlm_lm.core.twist import Twist
from geotlm_lm.track.events import COMPONENT_OF, MOVING, Event, EventKind, Span
from geotlm_lm.track.track import Track

FPS = 25.0


def happened(kind, begin, end, *, turn=0.0, right=0.0, down=0.0, inward=0.0, of=None, sure=0.98):
    """An event from frame `begin` to `end`; `of` is the kind of motion that a slip is."""
    kind = EventKind(kind)
    twist = Twist(turn, right, down, inward)
    component = COMPONENT_OF.get(EventKind(of) if of else kind)
    amounts = {"turn": turn, "slide": float(np.hypot(right, down)), "press": inward}
    far = 0.0 if component is None else amounts[component.value]
    amount = Span(far, 0.08 * abs(far))
    times = begin / FPS, end / FPS
    return Event(kind, begin, end, *times, twist, amount, sure, component)


def moving_track(steps, events, *, contact=None, frame_size=(120, 160)):
    """A track of these steps, one row a frame, as if touched throughout or with this `contact`."""
    count = len(steps)
    return Track(
        numbers=np.arange(count),
        times_s=np.arange(count) / FPS,
        contact=np.full(count, 0.99) if contact is None else np.asarray(contact),
        strength_grey=np.full(count, 5.0),
        twists=np.asarray(steps, float),
        covariances=np.tile(np.eye(4) * 1e-4, (count, 1, 1)),
        radius_px=np.full(count, 50.0),
        turn_shares=np.full(count, 0.16),
        events=tuple(events),
        frame_size=frame_size,
    )


def track_of_events(events, count=125):
    """The track in which these events happen evenly, and nothing else; touched between its ends."""
    steps, contact = np.zeros((count, 4)), np.zeros(count)
    for event in events:
        if event.kind in (*MOVING, EventKind.PRESS, EventKind.RELEASE) and event.end > event.begin:
            twist = event.twist
            parts = (twist.turn_deg, twist.right_px, twist.down_px, twist.inward_mm)
            steps[event.begin + 1 : event.end + 1] += np.array(parts) / (event.end - event.begin)
    touched = [one.begin for one in events if one.kind is EventKind.TOUCH]
    lifted = [one.end for one in events if one.kind is EventKind.RELEASE]
    if touched:
        contact[touched[0] : lifted[-1] if lifted else count] = 0.99
    return moving_track(steps, events, contact=contact)
