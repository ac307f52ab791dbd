"""Questions about what is watched, as far as it was seen when they are asked."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import geotlm_lm as lm

from .clips import LoadedClip
from .conversation import WATCHED, Talking, exchanges, in_frame
from .toolkit import COMPLAINT, Filled

NOW = re.compile(
    r"(?<!\bby )(?<!\bto )(?<!\buntil )(?<!\btill )\bnow\b|\b(currently|at the moment)\b",
    re.IGNORECASE,
)
"""What a question asks of the present by; of what happened by now it is asked of all."""

WATCH_FIRST = "Nothing was watched yet; start the camera or a recording first."

UNASKED: Filled = {"chat": exchanges(None), "framed": "", COMPLAINT: ""}


class LiveTalk(Talking):
    """Answers questions about what is watched, as far as it was seen when they are asked."""

    def ask(
        self, question: str, live: Any, facts: list[str], mm_per_px: float | None
    ) -> Iterator[Filled]:
        """As `Talking.ask`, unless something else is watched when the answer comes."""
        if (stream := live.stream) is None:
            raise lm.GeoTLMError(WATCH_FIRST)
        shown = stream.shown(is_now=bool(NOW.search(question)))
        for values in super().ask(question, shown, facts, mm_per_px):
            if live.stream is not stream:
                continue
            if "mm_per_px" in values:  # perhaps stated in the question
                for redrawn in self.resize(live, values["mm_per_px"]):
                    values |= redrawn
            yield values

    def session_of(self, live: Any) -> Any:
        """As `Talking.session_of`."""
        return None if live.stream is None else live.stream.session

    def redraw(self, _: LoadedClip) -> Filled:
        """Nothing yet: the stage shows more than the question was about."""
        return {}

    def beside(self, *_: Any) -> Filled:
        """Nothing: what an answer rests on is gone soon."""
        return {}

    def forget(self, live: Any, facts: list[str], *_: Any) -> Iterator[Filled]:
        """Begin the conversation anew; the frame that the page shows still holds."""
        if live.stream is not None:
            live.stream.forget_talk()
        chips = [] if live.stream is None else list(WATCHED)
        yield UNASKED | {"framed": in_frame(facts, None), "chips": chips}

    def resize(self, live: Any, mm_per_px: float | None) -> Iterator[Filled]:
        """Tell lengths by another size of a pixel."""
        size = lm.FrameSpec(mm_per_px=mm_per_px or None).mm_per_px
        if size == live.mm_per_px:
            return
        live.mm_per_px = size
        if live.stream is not None:
            yield {"stage": live.stream.stage(mm_per_px=size)}
