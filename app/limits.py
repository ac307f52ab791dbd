"""What the page, its programs and its agents may send and get: every limit, stated here alone."""

from __future__ import annotations

MIB = 2**20

UPLOAD_BYTES = 512 * MIB
"""Of a recording that is uploaded, or lies in the folder that is served."""

INLINE_BYTES = 64 * MIB
"""Of a recording inside a message; it is held in memory several times on its way."""

MESSAGE_BYTES = 2 * (INLINE_BYTES * 4 // 3) + MIB
"""Of a message to a tool: two recordings in base64, for a comparison, and what is said of them."""

QUESTION_CHARACTERS = 2000
"""Of a question; a longer one is more than what reads it takes."""

NAME_CHARACTERS = 400
"""Of a recording's name."""

TOPIC_CHARACTERS = 200
"""Of the name of a bag's topic."""

LISTED = 1000
"""Recordings of the folder that are listed."""

BUDGET_BYTES = 2048 * MIB
"""Of all recordings and messages that are in memory at once: those that are worked on, those that
visitors have open, and those that stay open; what is only kept goes first."""

EVENTS, ROWS = 200, 500
"""Events and frames that a tool tells of a track at most."""

AT_ONCE = 24
"""Requests that are worked on at once, taking turns at the model."""

QUEUE = 64
"""Requests that may wait beside these; one more is told to come back."""

KEPT_OPEN_BYTES = 512 * MIB
"""Of recordings that stay open for a tool's next question about them."""

KEPT_OPEN_S = 600.0
"""Time for which they do after the last one."""

SENTENCE = (
    f"A question may be {QUESTION_CHARACTERS} characters long, an upload "
    f"{UPLOAD_BYTES // MIB} MiB, a recording inside a message {INLINE_BYTES // MIB} MiB; "
    f"of a recording as many frames are read as fit {UPLOAD_BYTES // MIB} MiB (2,300 of 320 x 240 "
    f"pixels), evenly spread if it has more; a tool tells {EVENTS} events and {ROWS} frames at "
    f"most; {AT_ONCE} requests are worked on at once and {QUEUE} wait, as far as their recordings "
    f"fit into {BUDGET_BYTES // MIB} MiB together; one more is refused (HTTP status 429)."
)
"""The limits as people read them, on the page, by the tools and in the documentation."""
