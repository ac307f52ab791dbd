"""Exact phrases that state a fact about a recording, and the `FrameSpec` fields they set."""

from __future__ import annotations

from typing import Any

from geotlm_lm.core.frame_spec import FrameSpec

IMAGE = (
    r"(?:the |my )?(?:(?:camera|recorded|tactile) )?(?:image|picture|video|clip|recording|camera)"
)
_SENSOR = r"(?:the |my )?(?:sensor|gel|pad|camera|gripper|robot(?: arm)?|finger)"
_STAYED = (
    r"(?:stayed|stays|stood|was held|is held|is|was) (?:still|fixed|in place|put|clamped|at rest)"
    r"|(?:did not|didn't|does not|doesn't)(?: move)?|stood still"
)
_OTHER_SIDE = (
    r"(?:the )?(?:objects?'?s?|object's|other|opposite) (?:side|viewpoint|point of view|view)"
    r"|the side opposite (?:(?:of|to) )?the sensor"
    r"|(?:the|my) (?:\w+'s )?side,? opposite (?:(?:of|to) )?the sensor"
)
LOOK = r"(?:(?:i|we)(?:'m| am|'re| are)? |as )?(?:look|looking|see|seen|view|viewing|viewed|told)"
_MOVED = r"(?:moved|moves|turned|turns|slid|slides|is moving|was moving)"
_THING = r"(?!(?:sensor|gel|pad|camera|gripper|robot|finger)\b)\w+"
_OVER = r"(?: (?:over|across|along|past) (?:a|an|the|my)(?: \w+){1,2}?)?"
_I_MOVE = rf"(?:i|we) (?:moved?|turned?|rotated?|dragged?|slid|swept|twisted) {_SENSOR}{_OVER}"
_I_MOVED = rf"(?:{_SENSOR} {_MOVED}|{_I_MOVE})"
_TOUCHES = r"(?:touch|touches|touched|is on|is at|presses on|sees|see|looks at|look at|holds|grips)"
_TOUCHING = rf"(?:i'm|i am|we're|we are|{_SENSOR} is) (?:touching|holding|gripping|looking at)"
_THREADED = r"(?:thread|threads|screw|bolt|nut|threaded)"
_USUAL = r"(?:normal|standard|ordinary|usual|regular|common)"
_HEADED = r"(?:screw|bolt|nut|cap|lid|knob|jar|bottle|valve|tap|plug|object)"
_END_OF_IT = rf"(?:(?:the |my |its )?(?:{_HEADED}(?:'s)? )?{{0}}(?: of (?:the|my) {_HEADED})?)"
_LIES_ON = (
    r"(?:faces|touches|rests on|lies on|sits on|presses(?: (?:on|into|against|onto))?"
    r"|(?:(?:is|was) )?(?:(?:pressed|held) )?(?:on|at|against|into|onto|towards?))"
)
_REACHES = rf"(?:{_TOUCHES}|presses (?:against|onto|into)|faces|(?:(?:is|was) )?on(?: top of)?)"

HALF_TURN = r"(?:by )?180 ?(?:degrees|deg|°)(?: (?:counter)?clockwise)?"
UPSIDE_DOWN_PHRASE = (
    r"(?:(?:(?:turned|flipped|rotated|put|mounted|installed|held) )?(?:upside[ -]down|on its head)"
    rf"|(?:turned|rotated|mounted|installed) {HALF_TURN})"
)
_RIGHT_WAY_UP = r"(?:upright|(?:the )?right side up|(?:the )?right way (?:up|round|around))"
_NOT = r"(?: not| no longer|n't)"
MOUNTED = r"(?:the |my )?sensor (?:{}) (?:mounted|installed)"
"""A sensor held upside down for once shows the same image; one that is mounted so does not."""

_NOUN = r"(?!image\b|picture\b|video\b|clip\b|camera\b|sensor\b)\w+"
_IT_IS = r"(?:(?:it is|it's|it has|this is|i have|we have) )?"
_HAND = (
    rf"(?:(?:it is|it's|it has|this is|the thread is|(?:the|my) {_NOUN} (?:is|has)) )?"
    rf"(?:a )?(?:{_USUAL} )?{{}}(?: {_THREADED})?"
)

_SIDE = (
    rf"(?:(?:{_SENSOR}|i|we) {_TOUCHES}|{_TOUCHING}) (?:the|its) {{0}}(?: of (?:the|my) \w+)?"
    r"|(?:it is |it's )?(?:touched|gripped|held) (?:at|by|from|on) (?:the|its) {0}(?: side)?"
    r"|(?:i|we) (?:hold|held|grip|gripped|touch|touched) (?:the|my) \w+ (?:at|by|on) "
    r"(?:the|its) {0}"
    r"|(?:the )?{0} side"
)
_SEEN_AT = rf"|(?:{LOOK} )?(?:from|at) (?:the|its) {{}}(?: side)?"
"""Of a head and a shank alone: who looks from the side looks at no side of a bolt."""

_END = rf"{_END_OF_IT} {_LIES_ON} {_SENSOR}|{_SENSOR} {_REACHES} {_END_OF_IT}"
"""Which end of a thing touches, in its own words."""

_UPSIDE_DOWN, UPRIGHT = FrameSpec.fields_of_turn(180), FrameSpec.fields_of_turn(0)

FACTS: tuple[tuple[str, dict[str, Any]], ...] = (
    (
        rf"{IMAGE} (?:is|was) (?:mirrored|flipped)(?: left[ -]to[ -]right| horizontally)?",
        {"image_mirrored": True},
    ),
    (
        rf"{IMAGE} (?:is|was) (?:mirrored|flipped) (?:vertically|top[ -]to[ -]bottom)",
        {"image_mirrored": True, **_UPSIDE_DOWN},
    ),
    (r"(?:a )?mirrored (?:image|camera|video|clip|recording)", {"image_mirrored": True}),
    (r"there(?:'s| is) a mirror in the (?:optics|camera|sensor)", {"image_mirrored": True}),
    (
        rf"{IMAGE} (?:is|was){_NOT} (?:mirrored|flipped)(?: left[ -]to[ -]right)?"
        rf"|it(?:'s| is| was)(?:{_NOT}) mirrored|it isn't mirrored",
        {"image_mirrored": False},
    ),
    (r"there(?:'s| is) no mirror(?: in the (?:optics|camera|sensor))?", {"image_mirrored": False}),
    (
        rf"{IMAGE} (?:is|was|hangs|sits|stands|(?:is|was) (?:hanging|sitting)) {UPSIDE_DOWN_PHRASE}"
        rf"|{MOUNTED.format('is|was')} (?:upside[ -]down|on its head)"
        r"|(?:an )?upside[ -]down (?:image|camera|video|clip|recording)",
        _UPSIDE_DOWN,
    ),
    (
        rf"{IMAGE} (?:is|was){_NOT} {UPSIDE_DOWN_PHRASE}"
        rf"|{MOUNTED.format('is not|was not|isn.t|wasn.t')} (?:upside[ -]down|on its head)",
        {"image_upside_down": False},
    ),
    (
        rf"(?:{IMAGE} (?:is|was)(?: (?:mounted|installed))?|{MOUNTED.format('is|was')}) "
        rf"{_RIGHT_WAY_UP}",
        UPRIGHT,
    ),
    (
        rf"{IMAGE} (?:is|was) (?:(?:mirrored|flipped) and upside[ -]down"
        r"|upside[ -]down and (?:mirrored|flipped))",
        {"image_mirrored": True, **_UPSIDE_DOWN},
    ),
    (
        rf"(?:{LOOK}(?: it| at (?:it|(?:the|my) \w+))? )?from (?:{_OTHER_SIDE}|behind|the object)"
        rf"|{LOOK} through the object",
        {"viewpoint": "object"},
    ),
    (rf"(?:i am|i'm|i stand|i sit) (?:on|at) {_OTHER_SIDE}", {"viewpoint": "object"}),
    (
        rf"(?:{LOOK}(?: it| at it)? )?(?:from (?:behind )?{_SENSOR}(?:'s (?:side|view|viewpoint))?"
        rf"|through {_SENSOR})",
        {"viewpoint": "sensor"},
    ),
    (
        rf"{_SENSOR} {_MOVED}(?:,? (?:and )?not (?:the|my) {_THING}|,? (?:and|while) the {_THING} "
        r"(?:stayed|stays|is fixed|was fixed|stood still|is clamped))?",
        {"actor": "sensor"},
    ),
    (
        rf"{_SENSOR} {_MOVED},? (?:and |but |while )?(?:the|my) {_THING} (?:{_STAYED})",
        {"actor": "sensor"},
    ),
    (rf"(?:the|my) {_THING} (?:{_STAYED}),? (?:and |but |while )?{_I_MOVED}", {"actor": "sensor"}),
    (rf"{_I_MOVE}(?:,? (?:and )?not (?:the|my) \w+)?", {"actor": "sensor"}),
    (r"(?:the|my) object (?:is|was)(?: held)? (?:fixed|clamped)", {"actor": "sensor"}),
    (
        rf"(?:the|my) \w+ {_MOVED},? (?:and )?not {_SENSOR}",
        {"actor": "object"},
    ),
    (rf"{_SENSOR} (?:is|was) (?:fixed|clamped|mounted)", {"actor": "object"}),
    (
        _SIDE.format("head")
        + _SEEN_AT.format("head")
        + "|(?:the )?head|"
        + _END.format("(?:head|top)"),
        {"contact_side": "head"},
    ),
    (
        _SIDE.format("(?:shank|tip)")
        + _SEEN_AT.format("(?:shank|tip)")
        + "|(?:the )?(?:shank|tip)|"
        + _END.format("(?:shank|tip)"),
        {"contact_side": "shank"},
    ),
    (_SIDE.format("side") + r"|(?:a )?side grip", {"contact_side": "side"}),
    (_HAND.format(r"left[ -]?hand(?:ed)?"), {"thread": "left"}),
    (rf"{_IT_IS}(?:a )?reversed? {_THREADED}", {"thread": "left"}),
    (_HAND.format(r"right[ -]?hand(?:ed)?"), {"thread": "right"}),
    (
        rf"{_IT_IS}(?:a )?{_USUAL} {_THREADED}|(?:the|its) thread is (?:a )?{_USUAL}(?: one)?",
        {"thread": "right"},
    ),
    (
        r"(?:forget|reset|drop|ignore|unset) (?:the |my |what i said of the )?(?:pixel size|scale"
        r"|(?:size|width) of (?:a|one|the) pixel|mm per (?:pixel|px))",
        {"mm_per_px": None},
    ),
    (
        r"(?:reset|forget) (?:the frame|all that|what i said|everything|all(?: of (?:it|this))?)"
        r"|reset",
        {
            "image_mirrored": False,
            "viewpoint": "sensor",
            "actor": "object",
            "contact_side": None,
            "thread": None,
            "mm_per_px": None,
            **UPRIGHT,
        },
    ),
)
"""What may be said, to the letter, and the fields of `FrameSpec` it sets."""
