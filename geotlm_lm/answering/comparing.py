"""Answer what was understood of two clips: what each shows, and how they relate."""

from __future__ import annotations

from collections.abc import Sequence

from geotlm_lm.answering.answer import Answer, Comparison
from geotlm_lm.answering.asking import answer
from geotlm_lm.answering.deciding import (
    Decided,
    decided_parts,
    first_withheld,
    frame_after,
    guess_words,
    withheld_words,
)
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.evidence_of import recording_of
from geotlm_lm.answering.understanding import Understood
from geotlm_lm.answering.withholding import LEAST_SURE
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.edit import opposite
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED
from geotlm_lm.query import types as t
from geotlm_lm.query.forms import decided, in_form


def compare(
    bundle: Bundle,
    clips: tuple[Encoded, Encoded],
    understood: Understood,
    frame: FrameSpec,
) -> Comparison:
    """Answer a question about two clips."""
    first, second = clips
    now = frame_after(understood.query, frame, first.clip.frames.shape[2])
    open_ = Understood(t.Query((t.Part(t.Ask("way")),)), "way", 1.0)
    each = [answer(bundle, one, open_, now) for one in clips]
    query = understood.query
    if understood.ask_back is not None or not query.parts:
        text, sure, word = answer(bundle, second, understood, frame).text, 0.0, None
    else:
        text, sure, word = _compared(bundle, understood, decided_parts(query, frame, clips))
    relation = _relation(each)
    kind = query.parts[0].ask.kind if query.parts else "fact"
    if kind == "compare" and word is None and sure > 0:
        word = relation
    return Comparison(text, relation, sure, sure == 0.0, *each, word, kind, now, query)


def _compared(
    bundle: Bundle, understood: Understood, found: tuple[Decided, ...]
) -> tuple[str, float, str | None]:
    """Return the words of a comparison, how sure they are, and the deciding one."""
    form, decisions = understood.query.form, [one.decision for one in found]
    recording = recording_of(found[0].clips[0]).at_rate(decisions[0].frame.rate_hz, overrides=False)
    withheld = first_withheld(bundle, found)
    if withheld is not None:
        return withheld_words(withheld, understood), 0.0, None
    sure = understood.probability * min(one.probability for one in decisions)
    text = in_form(decisions, form, recording, sure=sure, keys=understood.keys)
    if any(one.missing is not None for one in decisions):
        return text, 0.0, None
    if sure < LEAST_SURE:
        return guess_words(text, understood, sure), 0.0, None
    return text, sure, decided(decisions[0], recording)


def _relation(each: Sequence[Answer]) -> str:
    one, other = (answer.direction for answer in each)
    if None in (one, other):
        return "unknown"
    if one == other:
        return "same"
    return "opposite" if one in DIRECTED and other == opposite(one) else "different"
