"""Claims and expectations put up for judgement: "she says it goes left. Is she right?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.plain_text import plain_text

_SAYS = (
    r"(?:say|think|believe|claim|insist|guess|swear|report|write|bet)(?:s|ed)?|said|thought|wrote"
    r"|told (?:me|us)|(?:is|was|am|are|'m) (?:sure|certain|convinced)"
)
_WHO = r"(?:i|we|you|he|she|they|somebody|someone|(?:the|my|our|a) (?:\w+ ){0,2}?\w+)"
_RIGHT, _WRONG = r"(?:right|correct|true|so)", r"(?:wrong|false|mistaken|incorrect)"
_PUT_UP = re.compile(rf"\b(?:{_RIGHT}|{_WRONG})[ ?.!]*$")
_JUDGED = re.compile(
    rf"(?:.*[.!;] )?(?:but )?{_WHO} (?:{_SAYS})(?: that)?,? (?P<claim>[^.,;?!]+)[.,;!?] "
    r"(?:so |and )?(?:is|am|are|was|were) (?:he|she|i|we|they|that|this|it|(?:the|my|our) \w+) "
    rf"(?:(?P<right>{_RIGHT})|{_WRONG})[ ?.!]*"
)
_WHO_IS_RIGHT = re.compile(
    r"(?P<claims>.+?)\b(?:who(?:'s| is| was| of (?:us|them) is)|which (?:of us|one|of them)? ?is)"
    rf" {_RIGHT}[ ?.!]*"
)
_EXPECTED = re.compile(
    r"(?:.*[.!;] )?(?:and |so |but |now )?(?P<who>it|this|that|(?:the|my) (?:\w+ )?\w+) "
    r"(?:should|must|ought to|has to|is (?:supposed|expected|meant) to) (?P<be>be )?"
    r"(?P<what>[^.,;?!]+?)"
    r"(?: (?:now|by now))?[.,;!] (?:so |and |but )?(?:is|was|does|did|has) (?:it|this|that)[ ?.!]*"
)
_MOVES_HOW = "Which way is it moving?"


def asked_of_report(question: str) -> str | None:
    """Return what a claim, or an expectation, put up for judgement asks; None of any other text.

    Of claims that differ ("he says left, I say right; who is right?") it is asked which way it is.
    """
    text = plain_text(question)
    if (said := _EXPECTED.fullmatch(text)) is not None:
        return f"{'Is' if said['be'] else 'Does'} {said['who']} {said['what']}?"
    if not _PUT_UP.search(text):
        return None
    if (said := _JUDGED.fullmatch(text)) is not None and len(motions_named(said["claim"])) == 1:
        true = "true" if said["right"] else "false"
        return f"Is it {true} that {said['claim']}?"
    said = _WHO_IS_RIGHT.fullmatch(text)
    return _MOVES_HOW if said is not None and len(motions_named(said["claims"])) > 1 else None
