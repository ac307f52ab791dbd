"""Add the other possible motions of an answer, with their probabilities."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.answer import Answer
from geotlm_lm.conversation.wording import motion_phrase
from geotlm_lm.core.labels import Motion

LEAST_TOLD = 0.005
"""A smaller probability is not worth telling."""

AT_MOST = 3
NOTHING_ELSE = f"Nothing else reaches {LEAST_TOLD:.1%}."


def with_alternatives(answer: Answer) -> Answer:
    """Return an answer on the direction with the other motions, the likeliest first.

    What was withheld for want of contact has no options and stays as it is.
    """
    if not answer.options:
        return answer
    told = answer.decided or max(answer.options, key=answer.options.get)
    # What holds beside the one told is no alternative to it.
    rest = {word: share for word, share in answer.options.items() if share < 0.5 and word != told}
    likeliest = sorted(rest, key=rest.get, reverse=True)[:AT_MOST]
    others = [
        f"{motion_phrase(Motion(word))} {share:.2g}%"
        for word in likeliest
        if (share := 100 * rest[word]) >= 100 * LEAST_TOLD
    ]
    said = f"Next likeliest: {', '.join(others)}." if others else NOTHING_ELSE
    share = answer.confidence or answer.options[told]
    return replace(answer, text=f"{answer.text} That is {share:.0%} probable. {said}")
