"""Questions for the reader's training: drawn afresh, spelled, laid together by length, and hidden.

Pairs come from the grammar and the corpus, so that no text comes twice but by chance; families held
out by the grammar are never drawn. Words are read from changing byte pairs (BPE-dropout, Provilkov
et al. 2020). Which byte pairs change no seed governs, as the tokenizer draws them.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count, islice, pairwise
from typing import NamedTuple, TypeAlias

import torch
from torch import Tensor
from torch.utils.data import DataLoader, IterableDataset, get_worker_info

from geotlm_lm.core.numbers import seed_for
from geotlm_lm.query.grammar import Pair, grammar
from geotlm_lm.query.reader import MOST_WORDS
from geotlm_lm.query.spelling import Spelling
from geotlm_lm.query.thesaurus import thesaurus

Row: TypeAlias = tuple[list[int], int]
"""A question's ids and its query's behind them, and where the query begins."""

EXCHANGED = 0.5
"""Of a text's tokens that are hidden from a taught reader, those that others stand for."""
LIGHTLY = 0.1
"""Share of a text's tokens hidden below which its label still holds."""
POOL = 16
"""Steps whose questions are drawn together, so that each step's are of about one length."""


class Batch(NamedTuple):
    """What of a step is learned from, b texts of s ids at most.

    Args:
        ids: Questions and queries, (b, s).
        shown: The same, some exchanged for others, (b, s).
        mask: What each may see, (b, 1, s, s).
        is_query: Where a query's token is, (b, s).
        is_seen: Whether a question's token is not hidden, (b, s).
        is_light: Whether little of a text is hidden, (b, 1).
    """

    ids: Tensor
    shown: Tensor
    mask: Tensor
    is_query: Tensor
    is_seen: Tensor
    is_light: Tensor


@dataclass(frozen=True)
class Drawing(IterableDataset):
    """The rows of pools of steps, one pool after the other, without end.

    Writing questions takes longer than learning from them on a GPU, so a `DataLoader` shares the
    pools among processes; each pool has its seed, and what comes is the same by any number of them
    where no byte pairs are left apart by chance.

    Args:
        spelling: Of questions and queries.
        corpus: Questions labelled one by one, of the training split.
        batch: Questions a step.
        corpus_share: Share of questions drawn from the corpus.
        room: Ids of the longest row.
        seed: Of all that is drawn.
        first: The first pool.
    """

    spelling: Spelling
    corpus: Sequence[Pair]
    batch: int
    corpus_share: float
    room: int
    seed: int
    first: int = 0

    def __iter__(self) -> Iterator[list[list[Row]]]:
        """Yield of each pool the rows of its steps."""
        worker = get_worker_info()
        place, stride = (worker.id, worker.num_workers) if worker else (0, 1)
        for pool in count(self.first + place, stride):
            yield self._pool(seed_for(self.seed, "reading", "pairs", pool))

    def _pool(self, seed: int) -> list[list[Row]]:
        rng = random.Random(seed)
        wanted = POOL * self.batch
        shown = round(wanted * self.corpus_share) if self.corpus else 0
        drawn = list(islice(grammar().pairs(seed, "train"), wanted - shown))
        labelled = rng.choices(list(self.corpus), k=shown) if shown else []
        labelled[::2] = [grammar().surrounded(rng, pair) for pair in labelled[::2]]
        pairs = drawn + labelled
        pairs[::2] = [thesaurus().varied(rng, pair) for pair in pairs[::2]]
        rows = rows_of(self.spelling, pairs, self.room)
        rng.shuffle(rows)
        rows.sort(key=lambda row: len(row[0]))
        ends = [place * len(rows) // POOL for place in range(POOL + 1)]
        steps = [rows[start:end] for start, end in pairwise(ends)]
        rng.shuffle(steps)
        return steps


def rows_from(drawing: Drawing, step: int, workers: int) -> Iterator[list[Row]]:
    """Yield each step's rows from `step` on, drawn by `workers` processes, or by this one for 0."""
    pool, skipped = divmod(step, POOL)
    drawing = replace(drawing, first=pool)
    context = "spawn" if workers else None
    pools = DataLoader(drawing, None, num_workers=workers, multiprocessing_context=context)
    for steps in pools:
        yield from steps[skipped:]
        skipped = 0


def rows_of(spelling: Spelling, pairs: Sequence[Pair], room: int) -> list[Row]:
    """Return the rows of the pairs that fit."""
    rows = []
    for pair in pairs:
        ids = spelling.question(pair.text).ids
        if len(ids) + MOST_WORDS <= room:
            rows.append((ids + spelling.query(pair.query.split()), len(ids)))
    return rows


def batch_of(
    rows: Sequence[Row], hidden: float, draws: torch.Generator, *, is_exchanged: bool
) -> Batch:
    """Return the rows of a step, words of each text hidden.

    Args:
        rows: Of all processes.
        hidden: Mean share of tokens that are hidden; each text's own is between none and twice it.
        draws: Draws which.
        is_exchanged: Whether others stand for some of them.
    """
    ids, mask, is_query = _laid(rows)
    share = 2 * hidden * torch.rand((len(ids), 1), generator=draws)
    is_hidden = (torch.rand(ids.shape, generator=draws) < share) & ~is_query
    shown = ids
    if is_exchanged:
        is_text = torch.arange(ids.shape[1]) < torch.tensor([[start - 1] for _, start in rows])
        others = ids[is_text]
        drawn = others[torch.randint(len(others), ids.shape, generator=draws)]
        is_other = torch.rand(ids.shape, generator=draws) < EXCHANGED
        is_other &= is_hidden & is_text
        shown, is_hidden = torch.where(is_other, drawn, ids), is_hidden & ~is_other
    return Batch(ids, shown, mask, is_query, ~is_hidden, share < LIGHTLY)


def _laid(rows: Sequence[Row]) -> tuple[Tensor, Tensor, Tensor]:
    """Return ids (b, s), what each may see (b, 1, s, s), and where a query's token is (b, s)."""
    length = rounded(max(len(ids) for ids, _ in rows), 8)
    ids = torch.tensor([row + [0] * (length - len(row)) for row, _ in rows])
    starts = torch.tensor([start for _, start in rows])[:, None]
    ends = torch.tensor([len(row) for row, _ in rows])[:, None]
    place = torch.arange(length)
    causal = place[None, :] <= place[:, None]
    mask = causal[None] | (place[None, None, :] < starts[:, None])
    return ids, mask[:, None], (place >= starts) & (place < ends)


def rounded(number: int, step: int) -> int:
    """Return a size rounded up: kernels are made once a shape, so few shapes are few kernels."""
    return -(-number // step) * step
