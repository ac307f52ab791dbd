"""Check that a question is not empty and not too long."""

from __future__ import annotations

from geotlm_lm.core.errors import UsageError

MAX_QUESTION_CHARACTERS = 500

OPEN_QUESTION = "Which way is it moving?"
"""Known to every model: asked where rules need the motion, and for words that no model knows."""


def check_question(question: str) -> str:
    """Return the question without surrounding blanks.

    Raises:
        UsageError: If nothing is left, it is too long, or it is no valid Unicode.
        TypeError: If it is no string.
    """
    if not isinstance(question, str):
        raise TypeError(
            f"a question is a str, found {type(question).__name__}; ask for example 'Which way "
            f"does it turn?'"
        )
    if any("\ud800" <= character <= "\udfff" for character in question):
        raise UsageError("the question holds bytes that are no text; type it as UTF-8.")
    question = " ".join(question.split())
    if not question:
        raise UsageError("the question is empty; ask for example 'Which way does it turn?'.")
    if len(question) > MAX_QUESTION_CHARACTERS:
        raise UsageError(
            f"the question has {len(question)} characters, expected at most "
            f"{MAX_QUESTION_CHARACTERS}; ask one short question at a time."
        )
    return question
