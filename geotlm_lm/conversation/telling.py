"""Put what is believed into words: what is asked about, else all that counts, larger first."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from geotlm_lm.conversation.felt import Felt, claim_of
from geotlm_lm.conversation.wording import direction_clause, frame_phrase
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.twist import COMPONENTS, Component

_DENIED = {
    Component.TURN: "turn",
    Component.SLIDE: "slide",
    Component.PRESS: "press in or lift off",
}
_GOES = {Component.TURN: "turns", Component.SLIDE: "slides"}
_GOING = {Component.TURN: "turning", Component.SLIDE: "sliding"}
_ALONG_THE_IMAGE = {Motion.PRESS: ("presses in", "pressing in")}
_ALONG_THE_IMAGE |= {Motion.RELEASE: ("lifts off", "lifting off")}

_UNREADABLE = {
    Component.SLIDE: "how far along the edge cannot be seen",
    Component.TURN: "how far it turns cannot be seen",
    Component.PRESS: "how deep cannot be seen",
}
"""Said in place of an amount that the picture does not tell."""


@dataclass(frozen=True)
class Told:
    """A clause on the motion.

    Args:
        text: It begins in lower case and has no stop.
        direction: The motion it is about, as the frame names it: of several the larger.
        confidence: Probability of the least sure thing it says.
        component: What its amount is of; None where it tells none.
        is_plain: Whether one motion, or rest, is all that it tells.
        is_doubtful: Whether what is asked is told not to count and may all the same.
    """

    text: str
    direction: Motion
    confidence: float
    component: Component | None = None
    is_plain: bool = True
    is_doubtful: bool = False


def tell(felt: Felt, frame: FrameSpec, asked: Collection[Component] = ()) -> Told:
    """Return what is believed as a clause.

    Args:
        felt: Named as `frame` does.
        frame: Whose words they are.
        asked: The components a question is about; none where it is about any.
    """
    denied = [one for one in COMPONENTS if one in asked and one not in felt.components]
    told = [one for one in felt.components if one in asked] if asked else list(felt.components)
    who = "the sensor" if frame.actor == "sensor" else "it"
    if Motion.NONE in felt.state:
        return _at_rest(felt, frame, denied if not told else [])
    doubtful = [one for one in denied if felt.is_barely(one)]
    if not denied:
        return _all(felt, frame, told, who) if told else _at_rest(felt, frame, [])
    if told:
        found = _all(felt, frame, told, who)
        rest = _negated(denied)
        sure = min(found.confidence, *(1 - felt.counts(one) for one in denied))
        return Told(f"{found.text}; it {rest}", found.direction, sure, found.component, False)
    if doubtful:
        return _doubtful(felt, frame, doubtful[0], who)
    if not felt.components:
        return _at_rest(felt, frame, denied)
    found = _all(felt, frame, felt.components, who)
    sure = min(found.confidence, *(1 - felt.counts(one) for one in denied))
    text = f"{who} {_negated(denied)}; {found.text}"
    return Told(text, found.direction, sure, found.component, found.is_plain)


def doing(felt: Felt, components: Sequence[Component], of: str = "") -> str:
    """Return what is believed as gerunds, "turning left and sliding down"; `of` is moved."""
    return _joined([_part(felt, one, is_gerund=True, of=of) for one in components])


def cannot_be_seen(component: Component) -> str:
    """Return that the picture does not tell how far a component goes, as a sentence."""
    verb = {**_GOES, Component.PRESS: "presses"}[component]
    return f"It {verb}; {_UNREADABLE[component]}."


MOST_OF_A_DOUBT = 0.75
"""Highest probability that the way of what may as well not count is told with."""

SURELY = 0.75
"""Probability of its way below which a component is told as a perhaps beside those that are surer:
a doubtful lesser part must not take a sure greater one with it."""


def _all(felt: Felt, frame: FrameSpec, told: Sequence[Component], who: str) -> Told:
    sure = [one for one in told if felt.said(one) >= SURELY] or list(told[:1])
    doubtful = [one for one in told if one not in sure]
    text = f"{who} {_joined([_part(felt, one) for one in sure])}{_where(felt, frame, sure)}"
    unseen = [_UNREADABLE[one] for one in sure if one in felt.unreadable]
    text = "; ".join([text, *unseen])
    if doubtful:
        text += f"; perhaps it also {_joined([_part(felt, one) for one in doubtful])}"
    way, is_between = felt.way(sure[0]), felt.ways[felt.way(sure[0])] < SURELY
    is_plain = len(told) == 1 and not unseen and not felt.is_barely(told[0])
    is_plain = is_plain and not (is_between and felt.aslant is not None)
    least = min(felt.ways[way] if is_plain else felt.said(one) for one in sure)
    return Told(text, way, least, None if sure[0] in felt.unreadable else sure[0], is_plain)


def _doubtful(felt: Felt, frame: FrameSpec, component: Component, who: str) -> Told:
    way, amount = felt.way(component), felt.amounts.get(component, "")
    if component is Component.PRESS:
        text = f"{who} hardly {_ALONG_THE_IMAGE[way][0]}, if at all"
    else:
        text = f"{who} hardly {_GOES[component]}, if at all {_named(felt, component)}"
    text += f", {amount}" if amount and component not in felt.unreadable else ""
    sure = min(felt.share(component), MOST_OF_A_DOUBT)
    if not felt.components:
        return Told(text + _where(felt, frame, [component]), way, sure, None, False, True)
    rest = _all(felt, frame, felt.components, who)
    return Told(f"{text}; {rest.text}", way, min(sure, rest.confidence), None, False, True)


def _at_rest(felt: Felt, frame: FrameSpec, denied: Sequence[Component]) -> Told:
    motion = felt.main
    text, sure = direction_clause(motion, frame), felt.probability(claim_of(frozenset({motion})))
    if denied:
        text = f"it {_negated(denied)}: {text}"
    return Told(text, motion, sure)


def _part(felt: Felt, component: Component, *, is_gerund: bool = False, of: str = "") -> str:
    way = felt.way(component)
    if component is Component.PRESS:
        text = _ALONG_THE_IMAGE[way][is_gerund]
    else:
        verb = (_GOING if is_gerund else _GOES)[component]
        text = " ".join(filter(None, (verb, of, _named(felt, component))))
    amount = "" if component in felt.unreadable else felt.amounts.get(component, "")
    if is_gerund or not felt.is_barely(component):
        return f"{text}, {amount}" if amount else text
    return f"{text}, barely: {amount}" if amount else f"{text}, barely"


def _named(felt: Felt, component: Component) -> str:
    way = felt.way(component)
    if component is Component.PRESS:
        return _ALONG_THE_IMAGE[way][1]
    is_aslant = component is Component.SLIDE and felt.aslant not in (None, way)
    return f"{way.value} and a little {felt.aslant.value}" if is_aslant else way.value


def _joined(parts: Sequence[str]) -> str:
    *others, last = parts
    if not others:
        return last
    return f"{', '.join(others)}{',' * any(',' in one for one in others)} and {last}"


def _where(felt: Felt, frame: FrameSpec, told: Sequence[Component]) -> str:
    """Return the frame, which a text with amounts sets off by a comma."""
    if not any(felt.way(one) in DIRECTED for one in told):
        return ""
    has_commas = any("," in _part(felt, one) for one in told)
    return f"{',' * has_commas} {frame_phrase(frame)}"


def _negated(denied: Sequence[Component]) -> str:
    return f"does not {' or '.join(_DENIED[one] for one in denied)}"
