"""Rewrite questions about contact and slip in the wording the model was trained on.

What has left the gel, what is held and what is pressed against it are asked of contact; slip is a
slide, as in the templates, and a turn only where it is called one.
"""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_words import GEL
from geotlm_lm.conversation.motion_verbs import TURN
from geotlm_lm.conversation.object_names import THING, with_generic_objects
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.question_affixes import JUST, TAIL
from geotlm_lm.conversation.text_normalisation import without_openers

_HOLD = r"(?:grasp|grip|hold)"
_HOLDER = rf"(?:gripper|{_HOLD}|hand|jaws?|fingers?|{GEL})"
_WHO = r"(?:i|we|you|the (?:gripper|robot|hand))"
_SOMETHING = r"(?:it|something|anything|(?:an|the|my) object)"
_SLIP = r"(?:slip(?:s|page|ping)?)"

_IS_TOUCHED = "Is anything touching the gel?"
_IS_LOST = "Has contact been lost?"
_IS_STILL = "Is it holding still?"
_SLIPS, _SLIDES, _TURNS = "Is it slipping?", "Is it sliding?", "Is it turning?"
_MOVES = "Is it moving at all?"

_SAID: tuple[tuple[str, str], ...] = (
    (
        rf"(?:has|have|had|did) {THING} {JUST}(?:left|leave"
        rf"|(?:slip(?:ped)?|fall(?:en)?|drop(?:ped)?|escaped?) (?:out of|off|from)) "
        rf"(?:the |my )?{_HOLDER}"
        rf"|(?:has|have|had|did) {_WHO} {JUST}(?:los[et]|miss(?:ed)?|drop(?:ped)?)"
        rf" (?:it|(?:the|my) (?:\w+))"
        rf"|(?:did|has|have|had) {THING} {JUST}(?:fall(?:en)?|drop(?:ped)?)(?: (?:down|off|out))?"
        rf"|(?:is|was) (?:{THING}|the {_HOLDER}) {JUST}(?:free of (?:any )?contact|out of touch)"
        rf"|(?:is|was) (?:the |my )?object {JUST}(?:gone|lost|missing)"
        rf"|(?:is|was) (?:the |my )?{_HOLDER} {JUST}(?:empty|free|clear)|empty {_HOLDER}"
        rf"|(?:is|was) (?:the |my )?{GEL} {JUST}idle|(?:the )?(?:contact|object|{_HOLD}) lost"
        rf"|(?:is|was) (?:{THING}) {JUST}(?:gone|lost)"
        rf"|lost (?:it|(?:the )?object|(?:the )?{_HOLD})"
        rf"|(?:is|was) {THING} {JUST}(?:falling|dropping|escaping)(?: (?:down|off|out))?"
        r"|(?:did|has|have) (?:the )?contact (?:break|broken|end|ended|stop|stopped|cease|ceased)",
        _IS_LOST,
    ),
    (
        rf"(?:do|did|have|am|are|is|does|has) {_WHO} {JUST}"
        rf"(?:(?:hold|holding|held|gripp?(?:ing|ed)?|grasp(?:ing|ed)?) "
        rf"(?:(?:the|my) \w+|{_SOMETHING})"
        rf"|(?:got|have|caught|got hold of) {_SOMETHING})"
        rf"|(?:do|did|can|could) you (?:feel|sense|detect|notice) {_SOMETHING}"
        rf"|(?:do|did|have) (?:i|we) (?:have|got|get|made?) (?:any |a )?contact"
        r"|(?:has|was) contact (?:been )?(?:made|established)"
        r"|(?:did|has|have) (?:the )?contact (?:start|begin|begun|occur|happen)(?:ed|red)?"
        rf"|(?:is|was) there (?:still|now|already|really) (?:(?:a|any) )?contact"
        rf"|(?:(?:is|was) (?:the |any )?)?contact {JUST}(?:present|there|detected|established)"
        rf"|there(?:'s| is| was) {JUST}(?:a |some )?contact"
        rf"|(?:is|was|are|were)n't (?:{THING}|{_WHO}) {JUST}(?:touching|touched|in contact)"
        rf"(?: (?:with )?(?:the {GEL}|{_SOMETHING}))?"
        rf"|(?:feel|felt|sense|sensed) {_SOMETHING}|got (?!it){_SOMETHING}|got it(?=\W*\?)"
        rf"|(?:did|has|have|had) {_WHO} {JUST}(?:grab(?:bed)?|catch|caught) "
        rf"(?:(?:the|my) \w+|{_SOMETHING})(?: up)?"
        rf"|(?:is|was) {THING} {JUST}(?:in|inside|between) (?:the|my|its|our) "
        rf"(?:gripper|hand|jaws?|fingers?|{_HOLD})"
        rf"|(?:is|was) (?:the|my) object {JUST}(?:present|there|detected)"
        rf"|(?:is|was) {THING} {JUST}(?:pressing|pushing) (?:against|on|onto) (?:the )?{GEL}"
        rf"|(?:is|was) there {_SOMETHING} (?:in|inside|between) (?:the|my|its|our) "
        rf"(?:gripper|hand|jaws?|fingers?|{_HOLD})"
        r"|anything|something|(?:is |was )?(?:an |any )?object (?:present|detected)"
        r"|(?:is|was) there really (?:something|anything)"
        rf"|(?:is|was) {THING} {JUST}(?:being )?(?:held|gripped|grasped)"
        rf"|(?:is|was) {THING} {JUST}pressed(?: (?:against|on|onto|to) (?:the )?{GEL})?",
        _IS_TOUCHED,
    ),
    (
        rf"(?:is|was) {THING} {JUST}being (?:pressed|pushed) (?:against|on|onto) (?:the )?{GEL}",
        f"{_IS_TOUCHED} Is it pressing in?",
    ),
    (
        rf"(?:(?:is|was) )?(?:(?:it|(?:the|my|this|a) {_HOLD}) )?(?:stable|steady)|stationary"
        rf"|(?:is|was) {THING} {JUST}idle"
        rf"|(?:is|was) it a (?:stable|steady) {_HOLD}"
        rf"|(?:has|have|had) {THING} {JUST}(?:settled|rested|held(?: still)?)"
        rf"|(?:has|have|had) {THING} {JUST}been (?:still|at rest)"
        rf"|(?:has|have|had) (?:the|my|this) {_HOLD} {JUST}held"
        rf"|(?:did|does) {THING} {JUST}(?:settle|rest)"
        rf"|(?:did|does|has|have|had) {THING} {JUST}(?:stay|remain)(?:ed)? "
        r"(?:put|in place|where it (?:is|was))",
        _IS_STILL,
    ),
    (
        rf"(?:is|was) (?:the|my|this) {_HOLD} (?:secure|safe|firm|tight|good)"
        r"|(?:describe|summari[sz]e)"
        r"(?: (?:it|this|that|(?:the|this|my) (?:clip|recording|object)))?"
        r"|(?:(?:the|a|your) )?(?:summary|status|state|result|report)(?: report)?"
        r"|label(?: (?:this|the) (?:clip|recording|motion))?|(?:the |its )?motion label"
        r"|what(?:'s| is) the (?:motion )?label|tell me (?:everything|all)"
        r"|what do you (?:notice|observe)|way|rot(?:ation)? dir(?:ection)?"
        r"|(?:(?:is|was) )?(?:(?:the|its) )?(?:rotation|turn|sense|sign|angle|theta|it)? ?"
        r"(?:positive or negative|negative or positive)(?: rotation)?",
        OPEN_QUESTION,
    ),
    (
        rf"(?:(?:is|was|does|did|has) {THING} {JUST}(?:going|moving|moved|go|gone|move) )?"
        r"(?:straight|in a (?:straight )?line)",
        _SLIDES,
    ),
    (
        rf"(?:(?:is|was|does|did|has) {THING} {JUST}(?:going|moving|moved|go|gone|move) )?"
        r"(?:in (?:a )?circles?|(?:a)?round and (?:a)?round|(?:a)?round in (?:a )?circles?)"
        rf"|(?:is|was|does|did|has) {THING} {JUST}(?:going|go|gone) (?:a)?round",
        _TURNS,
    ),
    (
        r"(?:along )?(?:which|what) axis|(?:is it )?(?:a )?(?:horizontal|vertical) or "
        r"(?:horizontal|vertical) (?:motion|movement|slide|slip)"
        rf"|along (?:which|what) axis (?:is|was|does|did) {THING} (?!{TURN})\w+",
        OPEN_QUESTION,
    ),
    (
        r"(?:(?:is|was|did|does|has) )?(?:anything|something)"
        r" (?:happen(?:s|ed|ing)?|chang(?:es|ed|e|ing)|going on)"
        rf"|(?:(?:is|was|does|did|has) {THING} {JUST})?mov(?:e|ed|ing) (?:a)?round",
        _MOVES,
    ),
    (
        rf"(?:(?:is|was) (?:there|this) )?(?:any |some |a )?(?:rotational|rotary|torsional) {_SLIP}"
        rf"|(?:does|did|is|was) {THING} {_SLIP} (?:in|by) (?:rotation|turning)"
        rf"|(?:does|did|is|was) {THING} {_SLIP} rotationally",
        _TURNS,
    ),
    (
        rf"(?:is|was|did|does|has|have) (?:the |any |a )?{_SLIP} (?:(?:been|being) )?"
        r"(?:(?:occur|happen)(?:s|r?ed|r?ing)?|start(?:ed|ing)?|begun|beginning|present|detected)"
        rf"|(?:please )?detect (?:any |the )?{_SLIP}|{_SLIP} detection[:,]?|gross {_SLIP}"
        rf"|(?:(?:is|was) there )?(?:(?:any|some|a) )?{_SLIP}(?: (?:detected|present|happening))?"
        rf"|(?:do|did|can|could|have) you (?:feel|felt|sense|notice|noticed|detect|detected|see) "
        rf"(?:any |some |a )?{_SLIP}",
        _SLIPS,
    ),
)

_PATTERNS = tuple(
    (re.compile(rf"(?:tell me[,:]? )?(?:{words}){TAIL}"), known) for words, known in _SAID
)


SLIP_IS_A_SLIDE = "Slip is taken for a slide; ask 'is it turning?' for a turn."
_NAMES_SLIP = re.compile(r"\bslip(?:s|ped|ping|page)?\b")


def names_slip(question: str) -> bool:
    """Tell whether `question` uses the word slip for a motion."""
    return bool(_NAMES_SLIP.search(question.lower()))


def in_canonical_words(question: str) -> str:
    """Rewrite a question for contact or slip in trained wording; others stay as they are.

    What asks for anything besides stays as it is.
    """
    text = without_openers(question)
    texts = (text, *with_generic_objects(text))
    return next((known for words, known in _PATTERNS if any(map(words.fullmatch, texts))), question)
