"""Questions that people may type, what is read of each and what the shipped model answers.

`python -m tests.conversation.questions` reads and asks all of them again and rewrites the file;
`python -m tests.conversation.questions --add < FILE` adds one question a line.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from geotlm_lm.answering import Answerer, Encoded
from geotlm_lm.answering.multi_clip import Comparison, Order
from geotlm_lm.answering.session import Reply
from geotlm_lm.recordings.read import read_clip
from tests.conversation.reading import reading

FILE = Path(__file__).resolve().parents[1] / "questions.jsonl"
EXAMPLES = Path(__file__).resolve().parents[2] / "app" / "examples"
ONE_CLIP = ("bottle_cap_clockwise", "pen_clip_left")
TWO_CLIPS = ("bottle_cap_clockwise", "hex_nut_counterclockwise")
BOTH = " and ".join(TWO_CLIPS)
"""Questions about two clips are asked of these, the second one given last."""

COLUMNS = 224
"""Width of the frames of every example."""


class Remembering:
    """A speaker that works out nothing twice: most questions come down to the same few.

    Args:
        speaker: What it asks the first time.
    """

    def __init__(self, speaker: Any) -> None:
        self._speaker = speaker
        self._known: dict[tuple[Any, ...], Any] = {}

    def would_write(self, fused_token: torch.Tensor, question: str, sentence: str) -> bool:
        """Return what the speaker does."""
        return self._once("would_write", fused_token, question, sentence)

    def score(self, fused_token: torch.Tensor, question: str, options: list[str]) -> Any:
        """Return what the speaker does."""
        return self._once("score", fused_token, question, options)

    def generate(self, fused_token: torch.Tensor, questions: list[str]) -> Any:
        """Return what the speaker does."""
        return self._once("generate", fused_token, questions)

    def _once(self, name: str, fused_token: torch.Tensor, *asked: Any) -> Any:
        key = (name, fused_token.numpy().tobytes(), *map(str, asked))
        if key not in self._known:
            self._known[key] = getattr(self._speaker, name)(fused_token, *asked)
        return self._known[key]


def remembering(answerer: Answerer) -> Answerer:
    """Return an answerer that says the same, sooner."""
    bundle = answerer.bundle
    return Answerer(replace(bundle, speaker=Remembering(bundle.speaker)))


def encoded_examples(answerer: Answerer) -> dict[str, Encoded]:
    """Return the clips that the questions are asked of, by name."""
    names = sorted({*ONE_CLIP, *TWO_CLIPS})
    return {name: answerer.encode(read_clip(EXAMPLES / f"{name}.npz")) for name in names}


def entries() -> list[dict[str, Any]]:
    """Return the questions as they were recorded."""
    return [json.loads(line) for line in FILE.read_text("utf-8").splitlines()]


def recorded(
    answerer: Answerer, clips: Mapping[str, Encoded], text: str, after: list[str], of: list[str]
) -> dict[str, Any]:
    """Return what is answered to one question, by the clips it is asked of.

    Args:
        answerer: The shipped model.
        clips: The examples.
        text: What is typed.
        after: The turns before it in the same conversation; without any it is asked by itself.
        of: Names of clips; `BOTH` for two.
    """
    of_clips = {note for encoded in clips.values() for note in encoded.clip.notes}
    return {name: told(asked(answerer, clips, name, text, after), of_clips) for name in of}


def asked(
    answerer: Answerer, clips: Mapping[str, Encoded], name: str, text: str, after: list[str]
) -> Reply:
    """Return the answer to a question by itself, or to one after others, or about two clips."""
    if name != BOTH and not after:
        return answerer.ask(clips[name], text)
    first, *others = TWO_CLIPS if name == BOTH else (name,)
    session = answerer.session(clips[first])
    for other in others:
        session.add_clip(clips[other])
    for turn in after:
        session.ask(turn)
    return session.ask(text)


def told(reply: Reply, of_clips: set[str]) -> dict[str, Any]:
    """Return what a reply says, as plain values, without the notes that any answer would have."""
    own: dict[str, Any] = {"text": reply.text}
    if isinstance(reply, Order):
        own["motions"] = [motion and motion.value for motion in reply.motions]
    elif isinstance(reply, Comparison):
        own |= {"relation": reply.relation, "decided": reply.decided}
    else:
        direction = reply.direction and reply.direction.value
        own |= {"kind": reply.kind, "decided": reply.decided, "direction": direction}
        own |= {"told_by": reply.told_by}
        notes = [note for note in reply.notes if note not in of_clips]
        own |= {"notes": notes} if notes else {}
    return own | {"confidence": round(reply.confidence, 6), "abstained": reply.abstained}


def everything(questions: list[tuple[str, list[str]]]) -> Iterator[dict[str, Any]]:
    """Yield an entry for each question, sorted."""
    torch.set_num_threads(1)
    answerer = remembering(Answerer.load())
    clips = encoded_examples(answerer)
    for text, after in sorted(questions):
        read = reading(text, COLUMNS)
        is_of_two = "of_two" in read or read.get("kind") in ("comparison", "order")
        of = [*ONE_CLIP, BOTH] if is_of_two and not after else list(ONE_CLIP)
        said = {"text": text, "after": after} if after else {"text": text}
        yield said | {"read": read, "answers": recorded(answerer, clips, text, after, of)}


def main() -> None:
    """Write the file again, with the questions of standard input where some are to be added."""
    known = {(one["text"], tuple(one.get("after", ()))) for one in entries()}
    if "--add" in sys.argv[1:]:
        known |= {(line.strip(), ()) for line in sys.stdin if line.strip()}
    lines = [
        json.dumps(entry, ensure_ascii=False, sort_keys=False)
        for entry in everything([(text, list(after)) for text, after in known])
    ]
    FILE.write_text("".join(f"{line}\n" for line in lines), "utf-8")


if __name__ == "__main__":
    main()
