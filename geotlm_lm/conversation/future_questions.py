"""Recognise questions about future motion, which no recording shows: "will it slip?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_words import HOLDER
from geotlm_lm.conversation.motion_verbs import GOES, LIFTS, NEARS, SLIDES, TURNS, forms
from geotlm_lm.conversation.object_names import THING, with_generic_objects
from geotlm_lm.conversation.question_affixes import JUST, TAIL, WHETHER
from geotlm_lm.conversation.text_normalisation import without_openers

NO_PREDICTION = (
    "I tell what the clip shows, not what comes next; ask for example 'is it slipping?' or 'which "
    "way does it turn?'."
)

_VERBS = TURNS + SLIDES + GOES + NEARS + LIFTS
_GO = forms(_VERBS, "base")
_MOVE = (
    rf"(?:{_GO}|be {forms(_VERBS, 'gerund')}|get {forms(_VERBS, 'past')}"
    rf"|(?:start|begin|stop|keep|go on|continue)(?: to)? {forms(_VERBS, 'base', 'gerund')})"
)
_WAY = (
    r"(?: (?:(?:to(?:wards?)?|on|off|over) (?:the )?)?(?:left|right|up|down|clockwise|away|out|off"
    r"|on|over|(?:counter|anti)[ -]?clockwise|c?cw|(?:left|right|up|down)wards?|further|more))?"
)
_SOON = r"(?:(?:still|ever|soon|again|next|probably|likely|just) )?"
_IT = rf"(?:{THING}|(?:the|my) (?:tactile )?{HOLDER})"
_TOUCHED = (
    r"(?:i|we|you|someone|the (?:robot|gripper|hand)) "
    r"(?:push|pull|press|squeez|let go|loosen|tighten|grip|pok|hit|twist|lift)\w*"
)
_ASKED = re.compile(
    rf"{WHETHER}(?:(?:(?:which way|what direction|which direction|where|how (?:far|fast|soon)) )?"
    rf"(?:(?:will|won't) {_IT} {_SOON}{_MOVE}"
    rf"|(?:is|was) {_IT} {JUST}(?:going to|bound to|gonna) {_SOON}{_MOVE})"
    rf"|(?:can|can't|would) {_IT} {_SOON}{_GO})"
    rf"{_WAY}(?: (?:soon|next|later|again))?{TAIL}"
    rf"|(?:would|will|could|can) {_IT} {_SOON}{_GO}{_WAY} if {_TOUCHED}\b.*"
    rf"|(?:how long|how much time)(?: will it (?:take|be))? (?:until|till|before)"
    rf" (?:{_IT}|(?:the )?contact)"
    rf" (?:{forms(_VERBS, 'third')}|(?:is|has|will|starts|begins|stops)\b.*){_WAY}{TAIL}"
    r"|(?:what(?:'s| is) the )?time (?:left )?(?:to|until|till)\b.*"
)
"""Nothing is said of what it could do: "could it turn clockwise?" may ask what it does."""


def asks_future_motion(question: str) -> bool:
    """Tell whether a whole text asks how something will move; nothing supposed before it."""
    return any(map(_ASKED.fullmatch, with_generic_objects(without_openers(question))))
