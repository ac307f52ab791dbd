"""Rewrite questions about screwing in or out, opening or closing as "does it tighten?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.text_normalisation import without_openers

_SCREWED = r"(?:screw|bolt|nut|thread|bulb)"
_CLOSES = r"(?:cap|lid|jar|bottle|stopper|tap|valve|faucet)"
_THE = r"(?:the|my|this|that) (?:\w+ )?"
_IS = r"(?:is|was|does|did|will|am|are)"
_TIGHTENS = r"(?:open(?:s|ed|ing)?|clos(?:e|es|ed|ing)|(?:un)?fasten(?:s|ed|ing)?)"
_ADVANCES = r"(?:advanc(?:e|es|ing)|retract(?:s|ing)?)"
_GOES = r"(?:go(?:es|ing)?|com(?:e|es|ing)|mov(?:e|es|ing))"
_IN_OUT = r"(?:further )?(?:in|out)"
_OR = r"(?: or (?:{0}))?"
_SCREW = rf"{_THE}{_SCREWED}"
_THREADED = rf"{_THE}(?:{_SCREWED}|{_CLOSES})"
_TIGHTENING = r"(?:opening|closing|(?:un)?fastening)"

_OF_A_THREAD = re.compile(
    rf"(?:{_IS} {_SCREW} {_GOES} {_IN_OUT}{_OR.format(_IN_OUT)}"
    rf"|{_IS} {_SCREW} {_ADVANCES}{_OR.format(_ADVANCES)}"
    rf"|(?:is|was|are) {_THREADED} (?:(?:being|getting) {_TIGHTENS}|{_TIGHTENING})"
    rf"{_OR.format(_TIGHTENS)}"
    rf"|(?:does|did) {_THREADED} {_TIGHTENS}{_OR.format(_TIGHTENS)}"
    rf"|{_IS} {_THREADED} {_TIGHTENS} or {_TIGHTENS}"
    rf"|{_IS} (?:it|this|that) being {_TIGHTENS}{_OR.format(_TIGHTENS)}"
    rf"|{_IS} (?:i|we|you|they) {_TIGHTENS}{_OR.format(_TIGHTENS)} (?:{_THREADED})"
    rf"|{_IS} {_THREADED} {_GOES} (?:off|on){_OR.format('off|on')}"
    rf"|{_IS} {_THE}(?:tap|valve|faucet) being turned (?:on|off){_OR.format('off|on')})[ ?.!]*"
)
"""Of things that have one."""

_WHERE_ONE_IS_KNOWN = re.compile(
    rf"(?:(?:{_IS} )?(?:(?:it|this|that) )?(?:{_GOES} )?{_IN_OUT}{_OR.format(_IN_OUT)}"
    rf"|(?:{_IS} )?(?:(?:it|this|that) )?(?:{_ADVANCES}|{_TIGHTENS})"
    rf"{_OR.format(f'{_ADVANCES}|{_TIGHTENS}')})[ ?.!]*"
)
"""Of whatever is touched, once its thread has been told."""

_TIGHTER_OR_LOOSER = "Is it tightening or loosening?"


def canonical_thread_question(question: str, is_known: bool) -> str:
    """Rewrite a question about a thread in trained wording; others stay as they are.

    Args:
        question: What is asked.
        is_known: Whether the thread of what is touched has been told.
    """
    text = without_openers(question)
    asks = _OF_A_THREAD.fullmatch(text) or (is_known and _WHERE_ONE_IS_KNOWN.fullmatch(text))
    return _TIGHTER_OR_LOOSER if asks else question
