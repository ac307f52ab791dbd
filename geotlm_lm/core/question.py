"""What may be asked: a text with something in it."""

from __future__ import annotations

from geotlm_lm.core.errors import UsageError

OPEN_QUESTION = "Which way is it moving?"


def check_question(question: object) -> str:
    """Return a question without the white space around it.

    Raises:
        UsageError: If it is empty, or no text.
        TypeError: If it is no text.
    """
    if not isinstance(question, str):
        raise TypeError(
            f"a question is a text, found {type(question).__name__}; give one such as "
            f"'{OPEN_QUESTION}'"
        )
    if not question.strip():
        raise UsageError(f"The question is empty; ask something like '{OPEN_QUESTION}'.")
    # Bytes that a terminal could not decode arrive as lone surrogates, which no tokenizer takes.
    if any("\ud800" <= letter <= "\udfff" for letter in question):
        raise UsageError("The question holds bytes that are no text; give it in UTF-8.")
    return question.strip()
