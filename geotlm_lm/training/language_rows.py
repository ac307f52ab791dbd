"""What the language model learns from: questions, English and answers, drawn afresh and laid out.

Questions come from the grammar, the corpus, programs composed at random and output forms, so that
no text comes twice but by chance; families held out by the grammar are never drawn. Words are read
from changing byte pairs (BPE-dropout, Provilkov et al. 2020); which of them change no seed governs,
as the tokenizer draws them.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count, islice, pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.utils.data import DataLoader, IterableDataset, get_worker_info

from geotlm_lm.core.numbers import seed_for
from geotlm_lm.language.size import PREFIX, SLOTS, TEXT
from geotlm_lm.query.reader import MOST_SAID, MOST_WORDS, SAY, SLOT_TOKENS, Spelling
from geotlm_lm.training.composed import composed
from geotlm_lm.training.forms import formed
from geotlm_lm.training.grammar import Pair, grammar
from geotlm_lm.training.swaps import swaps
from geotlm_lm.training.thesaurus import thesaurus
from geotlm_lm.training.truth import UNASKED

if TYPE_CHECKING:
    from geotlm_lm.training.sentences import Sentences

POOL = 16
"""Steps whose rows are drawn together, so that each step's are of about one length."""

PART = 1024
"""Positions that a processor learns from at once."""

LONGEST_PASSAGE = 64
"""Tokens of a passage of English that are read at once."""

MASKED = 0.3
"""Share of a passage's tokens that are hidden and asked for (Wettig et al. 2023 find more than the
usual 0.15 better for small models)."""

PAD, QUESTION, PROGRAM, SENTENCE, CLIP, SLOT = range(6)
"""Kinds of positions; what each may see is `sight`'s."""

SWAPPED = 0.7
"""Share of the labelled questions in which words may be exchanged together with their meaning."""

UNTOLD = 0.2
"""How often an answer that cannot tell is drawn against 1 for the others."""


class Row(NamedTuple):
    """One sequence: ids of its parts, and which clip stands before it."""

    question: list[int]
    program: list[int] = []
    sentence: list[int] = []  # from `SAY` on
    clip: int = UNASKED
    is_masked: bool = False  # whether hidden tokens of the question are asked for


class Batch(NamedTuple):
    """Rows as tensors, b of s positions at most.

    Args:
        ids: (b, s).
        kind: What stands where, (b, s).
        wanted: The id that is asked of the state at a place, `UNASKED` for none, (b, s).
        clip: Number of the clip before each row, (b,).
        is_masked: Whether a row's hidden tokens are asked for, (b,).
    """

    ids: Tensor
    kind: Tensor
    wanted: Tensor
    clip: Tensor
    is_masked: Tensor


def laid(rows: Sequence[Row], slot_ids: Sequence[int] = ()) -> Batch:
    """Return rows side by side, padded on the right; the slots' words are not filled in."""
    ids, kinds, wanted = [], [], []
    before = PREFIX + len(SLOTS) if rows[0].clip != UNASKED else 0
    for row in rows:
        parts = row.question, row.program, row.sentence
        text = [each for part in parts for each in part]
        kind = [
            name
            for name, part in zip((QUESTION, PROGRAM, SENTENCE), parts, strict=True)
            for _ in part
        ]
        # A program's words follow from the question, a sentence's from its beginning. What is
        # spoken of has been read by layers that learn no more.
        program = [UNASKED] * len(row.program) if row.sentence else row.program
        asked = [UNASKED] * len(row.question) + program
        asked += [UNASKED] * bool(row.sentence) + row.sentence[1:]
        asked = [*asked, UNASKED][1:]
        if before:
            text = [0] * PREFIX + list(slot_ids) + text
            kind = [CLIP] * PREFIX + [SLOT] * len(SLOTS) + kind
            asked = [UNASKED] * before + asked
        ids.append(text)
        kinds.append(kind)
        wanted.append(asked)
    length = rounded(max(map(len, ids)), 8)

    def padded(lists: list[list[int]], empty: int) -> Tensor:
        return torch.tensor([each + [empty] * (length - len(each)) for each in lists])

    return Batch(
        padded(ids, 0),
        padded(kinds, PAD),
        padded(wanted, UNASKED),
        torch.tensor([row.clip for row in rows]),
        torch.tensor([row.is_masked for row in rows]),
    )


def in_parts(batch: Batch, kind: str) -> Iterator[tuple[Batch, Tensor]]:
    """Yield a batch's rows in parts of about one length, each with the rows' numbers.

    On a processor a part of some `PART` positions stays in its cache: 1.6 to 2.6 times as fast as
    all rows at once. On a GPU all are one part.
    """
    lengths, left = (batch.kind != PAD).sum(1), (batch.kind != PAD).sum(1).argsort(stable=True)
    while len(left):
        # The rows left become longer, so that fewer of them may fit than by the first.
        widths = -(-lengths[left] // 8) * 8
        fits = (torch.arange(1, len(left) + 1) * widths <= PART) | (kind != "cpu")
        count = max(int(fits.sum()), 1)
        rows, left = left[:count], left[count:]
        cut = (each[rows, : widths[count - 1]] if each.ndim == 2 else each[rows] for each in batch)
        yield Batch(*cut), rows


def sight(kind: Tensor) -> Tensor:
    """Return what each position may see, (b, s) -> (b, 1, s, s).

    A question sees itself both ways, a program the question and what it has of itself; both are
    blind to the clip. A clip's prefix sees itself, a slot the prefix and itself. A sentence sees
    all before it.
    """
    looks, seen = kind[:, :, None], kind[:, None, :]
    place = torch.arange(kind.shape[1], device=kind.device)
    earlier = (place[None, :] <= place[:, None])[None]
    same = torch.eye(len(place), dtype=torch.bool, device=kind.device)[None]
    may = (looks == QUESTION) & (seen == QUESTION)
    may |= (looks == PROGRAM) & ((seen == QUESTION) | ((seen == PROGRAM) & earlier))
    may |= (looks == SENTENCE) & (seen != PAD) & earlier
    may |= ((looks == CLIP) | (looks == SLOT)) & (seen == CLIP)
    return (may | same)[:, None]


def positions(kind: Tensor) -> Tensor:
    """Return the position of each place, (b, s): a question begins at `TEXT` with a clip or not."""
    first = 0 if kind.numel() and int(kind[0, 0]) == CLIP else TEXT
    return (torch.arange(kind.shape[1], device=kind.device) + first).expand(kind.shape)


def hidden(batch: Batch, share: float, draws: torch.Generator) -> tuple[Tensor, Tensor]:
    """Return which tokens of the questions are hidden (b, s), and what is wanted, theirs among it.

    Args:
        batch: The rows.
        share: Mean share of the tokens that are hidden; each text's own is between none and twice
            it, and `MASKED` where they are asked for.
        draws: Draws which.
    """
    shares = 2 * share * torch.rand((len(batch.ids), 1), generator=draws)
    shares = torch.where(batch.is_masked[:, None], MASKED, shares)
    is_hidden = torch.rand(batch.ids.shape, generator=draws) < shares
    is_hidden &= batch.kind == QUESTION
    asked = is_hidden & batch.is_masked[:, None]
    return is_hidden, torch.where(asked, batch.ids, batch.wanted)


@dataclass(frozen=True)
class Questions(IterableDataset):
    """The batches of pools of steps, one pool after the other, without end.

    Writing questions takes longer than learning from them on a GPU, so a `DataLoader` shares the
    pools among processes; each pool has its seed, and what comes is the same by any number of them
    where no byte pairs are left apart by chance.

    Args:
        spelling: Of questions and programs.
        corpus: Questions labelled one by one, of the training split.
        batch: Questions a step.
        corpus_share: Share of questions drawn from the corpus.
        composed_share: Share of programs composed at random.
        forms_share: Share of questions that ask for an output of a given form.
        passages: Passages of English, of which `english` come beside each step's questions.
        english: How many.
        room: Ids of the longest row.
        seed: Of all that is drawn.
        first: The first pool.
    """

    spelling: Spelling
    corpus: Sequence[Pair]
    batch: int
    corpus_share: float
    composed_share: float
    forms_share: float
    passages: Sequence[str]
    english: int
    room: int
    seed: int
    first: int = 0

    def __iter__(self) -> Iterator[list[list[Batch]]]:
        """Yield of each pool the batches of its steps."""
        worker = get_worker_info()
        place, stride = (worker.id, worker.num_workers) if worker else (0, 1)
        for pool in count(self.first + place, stride):
            yield self._pool(seed_for(self.seed, "language", "pool", pool))

    def _pool(self, seed: int) -> list[list[Batch]]:
        rng = random.Random(seed)
        parts = []
        if self.batch:
            pairs = self._pairs(rng, seed)
            rows = rows_of(self.spelling, pairs, self.room)
            parts.append([laid(part) for part in _by_length(rows, rng)])
        if self.english and self.passages:
            texts = rng.choices(self.passages, k=POOL * self.english)
            rows = [english_row(self.spelling, text, rng) for text in texts]
            parts.append([laid(part) for part in _by_length(rows, rng)])
        return [list(step) for step in zip(*parts, strict=True)]

    def _pairs(self, rng: random.Random, seed: int) -> list[Pair]:
        wanted = POOL * self.batch
        shown = round(wanted * self.corpus_share) if self.corpus else 0
        made = round(wanted * self.composed_share)
        of_forms = round(wanted * self.forms_share)
        drawn = list(islice(grammar().pairs(seed, "train"), wanted - shown - made - of_forms))
        labelled = rng.choices(list(self.corpus), k=shown) if shown else []
        labelled = [
            swaps().exchanged(rng, pair) if rng.random() < SWAPPED else pair for pair in labelled
        ]
        labelled[::2] = [grammar().surrounded(rng, pair) for pair in labelled[::2]]
        pairs = drawn + labelled
        pairs[::2] = [thesaurus().varied(rng, pair) for pair in pairs[::2]]
        pairs += islice(formed(rng, "train"), of_forms)
        return pairs + list(islice(composed(rng), made))


def _by_length(rows: list[Row], rng: random.Random) -> list[list[Row]]:
    """Return a pool's rows as those of its steps, each of about one length."""
    rng.shuffle(rows)
    rows.sort(key=lambda row: len(row.question) + len(row.program) + len(row.sentence))
    ends = [place * len(rows) // POOL for place in range(POOL + 1)]
    steps = [rows[start:end] for start, end in pairwise(ends)]
    rng.shuffle(steps)
    return steps


def rows_of(spelling: Spelling, pairs: Sequence[Pair], room: int) -> list[Row]:
    """Return the rows of the pairs that fit."""
    rows = []
    for pair in pairs:
        ids = spelling.question(pair.text).ids
        if len(ids) + MOST_WORDS <= room:
            rows.append(Row(ids, spelling.query(pair.query.split())))
    return rows


def english_row(spelling: Spelling, text: str, rng: random.Random) -> Row:
    """Return a passage with words to guess, or the beginning of one that goes on."""
    ids = spelling.text(text)
    start = rng.randrange(max(len(ids) - LONGEST_PASSAGE, 0) + 1)
    ids = ids[start : start + LONGEST_PASSAGE]
    if rng.random() < 0.5:
        return Row(ids, is_masked=True)
    cut = rng.randint(1, len(ids))
    return Row(ids[:cut], sentence=[spelling.id_of[SAY], *ids[cut:]])


@dataclass(frozen=True, eq=False)
class Answers:
    """Draws answers about clips."""

    sentences: Sentences
    spelling: Spelling

    def pool(self, rng: np.random.Generator, count: int) -> list[Batch]:
        """Return the rows of `POOL` steps, each step's about `count` of one length."""
        drawn = rng.choice(len(self.sentences.rows), size=POOL * count, p=self._shares)
        rows = list(filter(None, map(self._row, drawn)))
        rows.sort(key=lambda row: len(row.question) + len(row.program) + len(row.sentence))
        ends = [place * len(rows) // POOL for place in range(POOL + 1)]
        slots = [self.spelling.id_of[token] for token in SLOT_TOKENS]
        parts = [laid(rows[start:end], slots) for start, end in pairwise(ends)]
        parts = [_with_words(part, self.sentences, self.spelling) for part in parts]
        return [parts[place] for place in rng.permutation(POOL)]

    @cached_property
    def _shares(self) -> NDArray[np.float64]:
        """How often each row is drawn: what tells nothing seldom, as it is always the same."""
        weights = np.array([1.0 if row.is_told else UNTOLD for row in self.sentences.rows])
        return weights / weights.sum()

    def _row(self, place: int) -> Row | None:
        row = self.sentences.rows[place]
        sentence = self.spelling.sentence(row.sentence)
        if sentence is None or len(sentence) > MOST_SAID:
            return None
        question = self.spelling.question(row.text).ids
        return Row(question, self.spelling.query(row.query.split()), sentence, row.clip)


@dataclass(frozen=True, eq=False)
class Clips:
    """Draws clips, of which the words at their slots are asked."""

    sentences: Sentences
    spelling: Spelling

    def pool(self, rng: np.random.Generator, count: int) -> list[Batch]:
        """Return the clips of `POOL` steps, `count` each."""
        drawn = rng.choice(len(self.sentences.numbers), size=(POOL, count))
        slots = [self.spelling.id_of[token] for token in SLOT_TOKENS]
        parts = (laid([Row([], clip=clip) for clip in row], slots) for row in drawn)
        return [_with_words(part, self.sentences, self.spelling) for part in parts]


def _with_words(batch: Batch, sentences: Sentences, spelling: Spelling) -> Batch:
    """Return a batch with the true words at its clips' slots asked."""
    wanted = batch.wanted.clone()
    places = (batch.kind[0] == SLOT).nonzero()[:, 0]
    for slot, (place, words) in enumerate(zip(places, SLOTS.values(), strict=True)):
        # What is unasked counts from the end.
        ids = torch.tensor([*(spelling.id_of[word] for word in words), UNASKED])
        wanted[:, place] = ids[torch.from_numpy(sentences.words[batch.clip.numpy(), slot]).long()]
    return batch._replace(wanted=wanted)


def steps_from(
    drawing: Questions, step: int, workers: int, passes: int = 1
) -> Iterator[list[Batch]]:
    """Yield each step's batches from `step` on, drawn by `workers` processes, or by this one for 0.

    Every pool is learned from `passes` times, words of it hidden anew.
    """
    pool, skipped = divmod(step, POOL * passes)
    drawing = replace(drawing, first=pool)
    context = "fork" if workers else None
    pools = DataLoader(drawing, None, num_workers=workers, multiprocessing_context=context)
    for steps in pools:
        yield from (steps * passes)[skipped:]
        skipped = 0


def rounded(number: int, step: int) -> int:
    """Return a size rounded up: kernels are made once a shape, so few shapes are few kernels."""
    return -(-number // step) * step
