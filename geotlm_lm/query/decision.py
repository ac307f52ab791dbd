"""Answers without words, and what they rest on."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from geotlm_lm.core.edit import Edit
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF, Component
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.amounts import Measure, Recording
from geotlm_lm.query.happenings import Happening
from geotlm_lm.query.types import Part
from geotlm_lm.track.track import Track


@dataclass(frozen=True)
class ContactArea:
    """Where the recorded image is touched.

    Args:
        across: Share of the width from its left border to the middle of the contact.
        down: Share of the height from its top.
        share: Of the image that is covered.
    """

    across: float
    down: float
    share: float


@dataclass(frozen=True)
class Evidence:
    """What answers rest on.

    Args:
        belief: Of this clip, which is the first of two.
        second: The same of the other clip, if there is one.
        recording: The file that this clip is of.
        track: The whole recording over time, if it was followed.
        area: Where it is touched; None where nothing is, or nobody looked.
        reasons: Sentences on what the picture shows, before any motion is named.
    """

    belief: Belief
    second: Evidence | None = None
    recording: Recording = field(default_factory=Recording)
    track: Track | None = None
    area: ContactArea | None = None
    reasons: tuple[str, ...] = ()

    def at_rate(self, rate_hz: float | None) -> Evidence:
        """Return this at a stated frame rate; of two recordings what a file tells stays."""
        if self.second is None:
            return replace(self, recording=self.recording.at_rate(rate_hz))
        first, second = (
            replace(one, recording=one.recording.at_rate(rate_hz, overrides=False))
            for one in (self, self.second)
        )
        return replace(first, second=second)


@dataclass(frozen=True)
class Movement:
    """One component as it is told.

    Args:
        way: Where it goes, of a slide the nearest of four ways.
        aslant: The lesser way of a slide between two.
        amount: How far; None where the picture does not tell, or no scale is known.
        chance: That it moves and goes that way.
        barely: Whether it goes less than a pixel.
        times: From when to when it goes on, seconds; None of a clip.
        back_and_forth: The whole way, there and back, where that is well above the net one.
    """

    way: Motion
    aslant: Motion | None
    amount: Measure | None
    chance: float
    barely: bool
    times: tuple[float, float] | None = None
    back_and_forth: Measure | None = None

    @property
    def component(self) -> Component:
        """What moves."""
        return COMPONENT_OF[self.way]


Limit = tuple[Component, tuple[Measure, ...]]
"""A component and how far it has to go to be seen; of rest the slide's stands for turns too."""


@dataclass(frozen=True)
class Decision:
    """An answer without words.

    Args:
        part: What it answers.
        frame: In which the recording's facts hold.
        verdict: Of a yes-or-no question.
        movements: What moves, the larger first: of what is asked, or all where none of that does.
        denied: Components that are asked about and are not seen to move.
        still_axis: "x" or "y", the one that is asked about, where what slides does not along it.
        rest: Stillness or absence, where nothing moves.
        limits: Of what is denied or at rest, how far it has to go to be seen.
        options: Places of the options that are so.
        amounts: What is measured.
        chances: Of each option, movement or clip, as the ask has it.
        times: Seconds, or numbers of times.
        happenings: Events of a recording that are told.
        area: Where it is touched, from this point of view.
        reasons: What the answer rests on, a sentence each.
        probability: That it is right, of the least sure thing it says.
        missing: Why it cannot be told; None where it is.
        is_frame_known: The point of view was named in the sentences before.
        each: Of two clips what answers the same of either.
        is_contact_known: Whether anything tells that something touches.
        recording: The file that it is told of; None where it is the one at hand.
    """

    part: Part
    frame: FrameSpec
    verdict: bool | None = None
    movements: tuple[Movement, ...] = ()
    denied: tuple[Component, ...] = ()
    still_axis: str | None = None
    rest: Motion | None = None
    limits: tuple[Limit, ...] = ()
    options: tuple[int, ...] = ()
    amounts: tuple[Measure, ...] = ()
    chances: tuple[float, ...] = ()
    times: tuple[float, ...] = ()
    happenings: tuple[Happening, ...] = ()
    area: ContactArea | None = None
    reasons: tuple[str, ...] = ()
    probability: float = 1.0
    missing: str | None = None
    is_frame_known: bool = False
    each: tuple[Decision, ...] = ()
    is_contact_known: bool = True
    recording: Recording | None = None

    @property
    def edit(self) -> Edit:
        """The whole point of view, from the recorded image."""
        return self.part.edit.within(self.frame.edit)
