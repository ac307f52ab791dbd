"""The language model's corpus: questions about simulated clips, and what is answered to them.

A clip is simulated, recorded and perceived like any other; programs of the training split are
evaluated on what is believed of it and worded as the product words them. Kept is what is true of
what was simulated, and of answers that cannot tell one in three rows at most. Nothing is read: what
a text means comes with it.
"""

from __future__ import annotations

import json
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import chain, count, islice
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.answering.answerer import CAMERA, Answerer
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.perceiving import reading
from geotlm_lm.answering.pipeline import worded_values
from geotlm_lm.answering.understanding import OF_BEFORE, OF_TWO, Asked
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.core.twist import COMPONENTS
from geotlm_lm.language.size import SLOTS
from geotlm_lm.query.copied import copied
from geotlm_lm.query.lines import read
from geotlm_lm.query.program import ATOM_OF, MOST_COPIED, MOST_SLOTS, Program, filled, is_void
from geotlm_lm.query.quantities import find
from geotlm_lm.runs.run import Workers, do_parts
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.training.config import VALIDATION_EVERY, claim_folder
from geotlm_lm.training.examples import ExampleSet, RecordedForm
from geotlm_lm.training.grammar import Pair, corpus, grammar
from geotlm_lm.training.true_answers import TrueAnswers, tells
from geotlm_lm.training.truth import UNASKED, component_truth

PART_CLIPS = 256
"""Clips of a file."""

UNTOLD_SHARE = 1 / 3
"""Most of a part's rows that tell nothing but that it cannot be told."""

MOST_DRAWN = 2
"""Questions drawn for one that is asked, at most: in place of what is not told others are."""

NEVER = frozenset({*OF_TWO, *OF_BEFORE, "talk", "not-understood"})
"""Words of programs that ask nothing of one clip by itself."""


class Row(NamedTuple):
    """A question about a clip and its answer."""

    clip: int  # place of its numbers
    text: str
    query: str  # line of the program, numbers and copied words as slots
    sentence: str
    is_told: bool  # whether anything that was asked could be told


@dataclass(frozen=True, eq=False)
class Sentences:
    """The corpus.

    Args:
        numbers: What the language model reads of each clip, (clips, width).
        words: Places of the true words at each clip's slots, as `felt_words` has them, (clips, 4).
        labels: The truth about each clip.
        rows: Questions about the clips.
        asked: How many were asked: the answers to the others were not true.
    """

    numbers: NDArray[np.float16]
    words: NDArray[np.int8]
    labels: tuple[MotionLabel, ...]
    rows: tuple[Row, ...]
    asked: int


def write_sentences(
    folder: Path,
    seen_by: Path | Bundle | None,
    clips: int,
    per_clip: int,
    seed: int,
    workers: int = 1,
    progress: Progress = silent,
) -> None:
    """Write the parts of the corpus that are not yet in `folder`.

    Args:
        folder: Of this corpus alone.
        seen_by: The model, or its folder; None takes the one that ships with the package.
        clips: How many are simulated; those that no reader would take are left out.
        per_clip: Questions about each.
        seed: Of all that is drawn; what is written does not depend on `workers`.
        workers: Processes; one is this process.
        progress: Called after every part.

    Raises:
        UsageError: If the folder holds another corpus.
    """
    about = {"clips": clips, "per_clip": per_clip, "seed": seed, "part": PART_CLIPS}
    claim_folder(folder, about | {"model": _answerer(seen_by).bundle.digest()})
    firsts = range(0, clips, PART_CLIPS)
    parts = [(place, first, min(PART_CLIPS, clips - first)) for place, first in enumerate(firsts)]
    jobs = [(part, folder / f"part_{part[0]:04d}.npz") for part in parts]
    do_parts(
        f"write sentences about {PART_CLIPS} clips",
        partial(_part, seen_by, per_clip, seed),
        jobs,
        _save,
        size=lambda part: part[2],
        workers=Workers(workers),
        progress=progress,
    )


def read_sentences(folder: Path) -> Sentences:
    """Return all parts that are in a folder, one behind the other."""
    numbers, words, labels, rows, asked, first = [], [], [], [], 0, 0
    for path in sorted(folder.glob("part_*.npz")):
        with np.load(path) as part:
            numbers.append(part["numbers"])
            words.append(part["words"])
            about = json.loads(part["about"].tobytes())
        labels += map(MotionLabel.from_dict, about["labels"])
        rows += [Row(first + clip, *rest) for clip, *rest in about["rows"]]
        asked += about["asked"]
        first = len(labels)
    return Sentences(
        np.concatenate(numbers), np.concatenate(words), tuple(labels), tuple(rows), asked
    )


def felt_words(labels: Sequence[MotionLabel]) -> Tensor:
    """Return the place of the true word at each slot, `UNASKED` where nothing is asked, (n, 4)."""
    places = []
    for label in labels:
        truth, row = component_truth(label), []
        for component in COMPONENTS:
            words, wanted = SLOTS[component], truth.moves[component]
            if wanted:
                row.append(words.index(ATOM_OF[truth.twist.way(component)]))
            else:
                row.append(UNASKED if wanted is None else words.index("none"))
        places.append([*row, SLOTS["contact"].index("touch" if truth.is_touched else "none")])
    return torch.tensor(places)


@lru_cache(maxsize=1)
def _answerer(seen_by: Path | Bundle | None) -> Answerer:
    return Answerer(seen_by) if isinstance(seen_by, Bundle) else Answerer.load(seen_by)


def _part(
    seen_by: Path | Bundle | None, per_clip: int, seed: int, part: tuple[int, int, int]
) -> dict[str, Any]:
    """Return a part's numbers, slots' words, and what is stored besides."""
    (number, first, size), bundle = part, _answerer(seen_by).bundle
    questions = _questions(seen_by, seed_for(seed, "sentences", "part", number))
    numbers, labels, rows, asked, untold = [], [], [], 0, 0
    for recorded in _recorded(seed, first, size):
        encoded = _encoded(seen_by, recorded)
        if encoded is None:
            continue
        about, ends_at = Asked(bundle, (encoded,), CAMERA), asked + per_clip
        truth = TrueAnswers.of(about.evidence[0], recorded.label)
        for pair, program in islice(questions, MOST_DRAWN * per_clip):
            if asked == ends_at:
                break
            answered = worded_values(about, program)
            is_told = any(map(tells, answered.values))
            if not is_told and untold + 1 > UNTOLD_SHARE * (len(rows) + 1):
                continue
            asked += 1
            if not is_told or truth.agree(answered, program, CAMERA):
                untold += not is_told
                rows.append(Row(len(labels), pair.text, pair.query, answered.wording.text, is_told))
        numbers.append(reading(encoded).half().numpy())
        labels.append(recorded.label)
    words = felt_words(labels).reshape(-1, len(SLOTS)).numpy().astype(np.int8)
    about = {"labels": [each.to_dict() for each in labels], "rows": rows, "asked": asked}
    return {"numbers": np.array(numbers), "words": words, "about": about}


def _save(stream: IO[bytes], part: dict[str, Any]) -> None:
    about = np.frombuffer(json.dumps(part["about"]).encode(), np.uint8)
    np.savez_compressed(stream, **part | {"about": about})


def _recorded(seed: int, first: int, size: int) -> Iterator[RecordedForm]:
    """Yield clips of training's objects as training has them."""
    kept = TRAINING_OBJECTS[::VALIDATION_EVERY]
    objects = tuple(name for name in TRAINING_OBJECTS if name not in kept)
    wanted = ExampleSet("sentences", first + size, objects)
    stage_seed = int(generator_for(seed, "examples", wanted.stage).integers(2**62))
    for index, simulated in enumerate(wanted.simulated(stage_seed, first, size), start=first):
        yield wanted.recorded(simulated, generator_for(stage_seed, "form", index))


def _encoded(seen_by: Path | Bundle | None, recorded: RecordedForm) -> Encoded | None:
    """Return a clip as it is perceived, a pair as two frames; None where it is refused."""
    order = recorded.order
    clip = recorded.clip.select(sorted({order.index(each) for each in order}))
    if not recorded.is_idle_known:
        clip = replace(clip, background=None)
    try:
        return _answerer(seen_by).encode(clip)
    except UnreadableClip:
        return None


def _questions(seen_by: Path | Bundle | None, seed: int) -> Iterator[tuple[Pair, Program]]:
    """Yield what can be asked of one clip, of the grammar and of the corpus in turn."""
    rng, labelled = random.Random(seed), corpus("train")
    chosen = (rng.choice(labelled) for _ in count())
    both = (
        ((pair, program) for pair in pairs if (program := _program(seen_by, pair)))
        for pairs in (grammar().pairs(seed, "train"), chosen)
    )
    return chain.from_iterable(zip(*both, strict=True))


@lru_cache(maxsize=2**14)
def _program(seen_by: Path | Bundle | None, pair: Pair) -> Program | None:
    """Return what a text asks of one clip, with its numbers and words; None of anything else."""
    program = read(pair.query)
    words = {each.word for each in chain(*program.answers)}
    is_unclear = any(fact.name == "unclear" for fact in program.facts)
    if not program.answers or words & NEVER or is_unclear or is_void(program):
        return None
    numbers = [each.quantity for each in find(pair.text)[:MOST_SLOTS]]
    words = [each.text for each in copied(pair.text)[:MOST_COPIED]]
    try:
        program = filled(program, numbers, words)
    except IndexError:  # a slip was mended, and one of them is none any more
        return None
    return replace(program, answers=tuple(dict.fromkeys(program.answers)))
