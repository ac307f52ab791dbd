"""Train the reader of questions on pairs that the grammar and the corpus write.

Pairs are drawn afresh every step, so that no text comes twice but by chance; families held out by
the grammar are never drawn. Words are read from changing byte pairs (BPE-dropout, Provilkov et al.
2020) and some are hidden, so that no phrase is known by one spelling alone. Which byte pairs change
no seed governs, as the tokenizer draws them: two runs of one seed are alike, not equal.
"""

from __future__ import annotations

import math
import random
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from itertools import islice
from pathlib import Path

import torch
from tokenizers import Tokenizer
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits, cross_entropy, pad

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.interrupts import uninterrupted_step
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.core.seeding import seed_for
from geotlm_lm.language.decoder import LanguageSize, initialise
from geotlm_lm.language.tokenizer import byte_pairs
from geotlm_lm.query.grammar import Pair, grammar
from geotlm_lm.query.labelled import Labelled
from geotlm_lm.query.lexicon import Lexicon
from geotlm_lm.query.reader import MOST_WORDS, SIZE, QuestionDecoder, Reader
from geotlm_lm.query.spelling import Spelling, plain_parts
from geotlm_lm.query.thesaurus import thesaurus
from geotlm_lm.training.checkpoint import load_checkpoint, save_checkpoint
from geotlm_lm.training.language import parameter_groups
from geotlm_lm.training.muon import Muon, orthogonal_groups
from geotlm_lm.training.ranks import ALONE, Ranks

NAME = "reading_checkpoint.pt"
CHECKPOINT_EVERY_S = 60.0
VOCABULARY_PAIRS = 60_000
"""Texts that the vocabulary of byte pairs is made from."""


@dataclass(frozen=True)
class ReadingTraining:
    """How the reader is trained.

    Args:
        steps: Optimiser steps.
        batch: Questions a step.
        learning_rate: Peak; rises over `warmup` steps and falls to nothing as a cosine.
        warmup: Steps of the rise.
        hidden: Share of a question's tokens that are hidden from it.
        dropout: Share of byte pairs that are left apart.
        corpus_share: Share of questions drawn from the corpus instead of the grammar, half of them
            with the grammar's clauses around.
        vocabulary: Byte pairs at most.
        seed: Of weights and draws.
        size: How large the model is.
    """

    steps: int = 3600
    batch: int = 128
    learning_rate: float = 2e-3
    warmup: int = 200
    hidden: float = 0.06
    dropout: float = 0.1
    corpus_share: float = 0.12
    vocabulary: int = 2000
    seed: int = 0
    size: LanguageSize = field(default_factory=lambda: SIZE)


def train_reader(
    config: ReadingTraining,
    folder: Path,
    corpus: Sequence[Pair] = (),
    progress: Progress = silent,
    ranks: Ranks = ALONE,
) -> Reader:
    """Return a reader, not yet calibrated; goes on from the checkpoint in `folder`.

    The first rank draws and spells each step's questions, whose byte pairs no seed governs, and all
    learn from their share.

    Args:
        config: How to train.
        folder: Where the checkpoint lies; the first rank writes it.
        corpus: Questions labelled one by one, of the training split.
        progress: Told after each step.
        ranks: Which process this is, and where it trains.

    Raises:
        UsageError: If the checkpoint belongs to another configuration, or the batch does not divide
            among the ranks.
    """
    ranks.refuse_uneven(config.batch)
    tokenizer, lexicon = ranks.from_first(lambda: train_vocabulary(config, corpus))
    spelling = Spelling(tokenizer, lexicon=lexicon)
    with torch.random.fork_rng(devices=[]):  # torch draws what is drawn again below
        model = QuestionDecoder(config.size, spelling.size).train()
    initialise(model, config.size.layers, _generator(config.seed, "weights"))
    model.to(ranks.device)
    optimiser = Muon(orthogonal_groups(parameter_groups(model)), betas=(0.9, 0.98))
    step = _restored(folder / NAME, config, model, optimiser)
    draws = _draws(config, corpus, step)
    saved_at = time.monotonic()
    try:
        while step < config.steps:
            for group in optimiser.param_groups:
                group["lr"] = rate_at(step, config)
            hides = _generator(config.seed, "hidden", step)
            rows = ranks.from_first(lambda: _spelled(next(draws), spelling, config))
            with uninterrupted_step():
                loss = _step(model, rows, optimiser, config, hides, ranks)
                step += 1
            progress(f"train reader, loss {loss:.3f}", step, config.steps)
            if ranks.is_first and time.monotonic() - saved_at > CHECKPOINT_EVERY_S:
                _store(folder / NAME, config, model, optimiser, step)
                saved_at = time.monotonic()
    finally:
        if ranks.is_first:
            _store(folder / NAME, config, model, optimiser, step)
    tokenizer.model.dropout = None
    return Reader(model.cpu(), spelling, (1.0, 0.0))


def calibrated_reader(reader: Reader, questions: Sequence[Labelled]) -> Reader:
    """Return a reader whose probabilities come true on questions that it was not trained on.

    The log-odds of what it tells are scaled and shifted to the greatest likelihood of whether its
    readings were the right ones (Platt 1999).
    """
    raw = Reader(reader.model, reader.spelling, (1.0, 0.0))
    odds, right = [], []
    for one in questions:
        found = raw.read(one.text)
        odds.append(math.log(found.probability / (1 - found.probability)))
        right.append(one.is_met(found.line))
    x, y = torch.tensor(odds), torch.tensor(right, dtype=torch.float32)
    line = torch.tensor([1.0, 0.0], requires_grad=True)
    optimiser = torch.optim.LBFGS([line], max_iter=100, line_search_fn="strong_wolfe")

    def loss() -> Tensor:
        optimiser.zero_grad()
        value = binary_cross_entropy_with_logits(line[0] * x + line[1], y)
        value.backward()
        return value

    optimiser.step(loss)
    slope, offset = map(float, line.detach())
    return Reader(reader.model, reader.spelling, (slope, offset))


def train_vocabulary(config: ReadingTraining, corpus: Sequence[Pair]) -> tuple[Tokenizer, Lexicon]:
    """Return byte pairs made from the texts of the training families, and their frequent words."""
    pairs = [*islice(grammar().pairs(config.seed, "train"), VOCABULARY_PAIRS), *corpus]
    texts = [part for pair in pairs for part in plain_parts(pair.text)]
    tokenizer = byte_pairs(texts, config.vocabulary)
    tokenizer.model.dropout = config.dropout
    return tokenizer, Lexicon.of(texts)


def rate_at(step: int, config: ReadingTraining) -> float:
    """Return the learning rate of a step."""
    if step < config.warmup:
        return config.learning_rate * (step + 1) / config.warmup
    share = (step - config.warmup) / max(config.steps - config.warmup, 1)
    return config.learning_rate * 0.5 * (1 + math.cos(math.pi * share))


def _draws(config: ReadingTraining, corpus: Sequence[Pair], step: int) -> Iterator[list[Pair]]:
    """Yield the pairs of each step from one on."""
    while True:
        seed = seed_for(config.seed, "reading", "pairs", step)
        rng = random.Random(seed)
        shown = round(config.batch * config.corpus_share) if corpus else 0
        drawn = list(islice(grammar().pairs(seed, "train"), config.batch - shown))
        labelled = rng.choices(list(corpus), k=shown) if shown else []
        labelled[::2] = [grammar().surrounded(rng, pair) for pair in labelled[::2]]
        pairs = drawn + labelled
        pairs[::2] = [thesaurus().varied(rng, pair) for pair in pairs[::2]]
        yield pairs
        step += 1


def rows_of(spelling: Spelling, pairs: Sequence[Pair], room: int) -> list[tuple[list[int], int]]:
    """Return of each pair that fits its ids, question and query, and where the query begins."""
    rows = []
    for pair in pairs:
        ids = spelling.question(pair.text).ids
        if len(ids) + MOST_WORDS <= room:
            rows.append((ids + spelling.query(pair.query.split()), len(ids)))
    return rows


def batch_of(rows: Sequence[tuple[list[int], int]]) -> tuple[Tensor, Tensor, Tensor]:
    """Return ids (b, s), what each may see (b, 1, s, s), and where a query's token is (b, s)."""
    length = _rounded(max(len(ids) for ids, _ in rows), 8)
    ids = torch.tensor([row + [0] * (length - len(row)) for row, _ in rows])
    starts = torch.tensor([start for _, start in rows])[:, None]
    ends = torch.tensor([len(row) for row, _ in rows])[:, None]
    place = torch.arange(length)
    causal = place[None, :] <= place[:, None]
    mask = causal[None] | (place[None, None, :] < starts[:, None])
    return ids, mask[:, None], (place >= starts) & (place < ends)


def _spelled(
    pairs: Sequence[Pair], spelling: Spelling, config: ReadingTraining
) -> list[tuple[list[int], int]]:
    """Return the rows of a step, the short ones first."""
    return sorted(rows_of(spelling, pairs, config.size.max_tokens), key=lambda row: len(row[0]))


def _step(
    model: QuestionDecoder,
    rows: Sequence[tuple[list[int], int]],
    optimiser: torch.optim.Optimizer,
    config: ReadingTraining,
    hides: torch.Generator,
    ranks: Ranks,
) -> float:
    """Learn from this rank's share of the rows; return the loss of all."""
    per_rank = sum(len(ids) - start for ids, start in rows) / ranks.count
    optimiser.zero_grad(set_to_none=True)
    total = 0.0
    parts = 8
    for place in range(parts):
        part = rows[place * len(rows) // parts : (place + 1) * len(rows) // parts]
        if part:
            batch = batch_of(part)
            is_seen = torch.rand(batch[0].shape, generator=hides) >= config.hidden
            mine = [ranks.share(one).to(ranks.device) for one in (*batch, is_seen)]
            if len(mine[0]):
                with ranks.bfloat16_products():
                    loss = _loss(model, *mine)
                (loss / per_rank).backward()
                total += loss.item()
    told = ranks.average(model.parameters(), total / per_rank)
    torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
    optimiser.step()
    return told


def _loss(
    model: QuestionDecoder, ids: Tensor, mask: Tensor, is_query: Tensor, is_seen: Tensor
) -> Tensor:
    """Return the summed cross entropy of the query's tokens, in nats.

    Args:
        model: The weights.
        ids: Questions and queries, (b, s).
        mask: What each may see, (b, 1, s, s).
        is_query: Where a query's token is, (b, s).
        is_seen: Whether a question's token is not hidden, likewise.
    """
    embedded = model.decoder.embed_tokens(ids)
    kept = is_seen | is_query
    states = model.decoder(embedded * kept[..., None], mask)
    before, wanted = states[:, :-1][is_query[:, 1:]], ids[is_query]
    spare = _rounded(len(wanted), 64) - len(wanted)
    before, wanted = pad(before, (0, 0, 0, spare)), pad(wanted, (0, spare), value=-1)
    logits = model.logits(before).float()
    return cross_entropy(logits, wanted, reduction="sum", ignore_index=-1)


def _generator(seed: int, *names: str | int) -> torch.Generator:
    return torch.Generator().manual_seed(seed_for(seed, "reading", *names))


def _rounded(count: int, step: int) -> int:
    """Return a size rounded up: kernels are made once a shape, so few shapes are few kernels."""
    return -(-count // step) * step


def _store(path: Path, config: ReadingTraining, model, optimiser, step: int) -> None:
    state = {"config": asdict(config), "step": step, "model": model.state_dict()}
    save_checkpoint(path, state | {"optimiser": optimiser.state_dict()})


def _restored(path: Path, config: ReadingTraining, model, optimiser) -> int:
    state = load_checkpoint(path)
    if state is None:
        return 0
    if state["config"] != asdict(config):
        raise UsageError(
            f"{path}: was trained with other settings; delete it to start over, or train into "
            f"another folder."
        )
    model.load_state_dict(state["model"])
    optimiser.load_state_dict(state["optimiser"])
    return int(state["step"])
