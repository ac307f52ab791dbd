"""Train the reader of questions: several that learn from labels, and one that learns from them.

Readers of other first weights err on other strange words. Their mean reads more rightly and knows
better when it does not; a reader that learns to tell what they tell together (distillation, Hinton
et al. 2015) keeps nearly all of that at the price of one. It sees texts with words hidden and
exchanged, and of those it is told how unsure its teachers are. Two runs of one seed are alike, not
equal: see `reading_rows`.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import islice
from pathlib import Path

import torch
from safetensors.torch import load_file
from tokenizers import Tokenizer
from torch import Tensor
from torch.nn.functional import cross_entropy, one_hot, pad

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.numbers import seed_for
from geotlm_lm.core.process import Progress, silent, uninterrupted_step
from geotlm_lm.language.decoder import LanguageSize, initialise
from geotlm_lm.language.tokenizer import byte_pairs
from geotlm_lm.query.grammar import Pair, grammar
from geotlm_lm.query.lexicon import Lexicon
from geotlm_lm.query.reader import SIZE, QuestionDecoder, Reader
from geotlm_lm.query.spelling import Spelling, plain_parts
from geotlm_lm.training.fit import load_checkpoint, save_checkpoint
from geotlm_lm.training.language import parameter_groups
from geotlm_lm.training.muon import Muon, orthogonal_groups
from geotlm_lm.training.ranks import ALONE, Ranks
from geotlm_lm.training.reading_rows import Batch, Drawing, Row, batch_of, rounded, rows_from

CHECKPOINT_EVERY_S = 60.0
VOCABULARY_PAIRS = 60_000
"""Texts that the vocabulary of byte pairs is made from."""

LABEL = 0.25
"""Weight of a label beside the teachers' word, of a text little of which is hidden."""


@dataclass(frozen=True)
class ReadingTraining:
    """How a reader is trained.

    Args:
        steps: Optimiser steps of each reader that learns from labels.
        teachers: How many of them teach the one that is made; without any it learns from labels.
        taught_steps: Steps of the one that is taught, from the weights of the first teacher.
        batch: Questions a step.
        learning_rate: Peak; rises over `warmup` steps and falls to nothing as a cosine. Half of it
            for a taught reader.
        warmup: Steps of the rise.
        hidden: Mean share of a question's tokens that are hidden from a reader; each question's own
            is between none and twice this. Twice of it for a taught reader.
        dropout: Share of byte pairs that are left apart.
        corpus_share: Share of questions drawn from the corpus instead of the grammar, half of them
            with the grammar's clauses around.
        vocabulary: Byte pairs at most.
        seed: Of weights and draws.
        size: How large the model is.
    """

    steps: int = 11_000
    teachers: int = 0
    taught_steps: int = 3_500
    batch: int = 512
    learning_rate: float = 3e-3
    warmup: int = 300
    hidden: float = 0.06
    dropout: float = 0.1
    corpus_share: float = 0.12
    vocabulary: int = 2000
    seed: int = 0
    size: LanguageSize = field(default_factory=lambda: SIZE)


@dataclass(frozen=True)
class _Shared:
    """What the readers of one training share."""

    spelling: Spelling
    corpus: Sequence[Pair]
    ranks: Ranks
    workers: int
    progress: Progress
    begun: tuple[dict[str, Tensor], dict[str, int]] | None = None  # weights, and ids of its words


def train_reader(
    config: ReadingTraining,
    folder: Path,
    corpus: Sequence[Pair] = (),
    progress: Progress = silent,
    ranks: Ranks = ALONE,
    workers: int = 0,
    start: Path | None = None,
) -> Reader:
    """Return a reader, not yet calibrated; goes on from the checkpoints in `folder`.

    The first rank draws and spells each step's questions, whose byte pairs no seed governs, and all
    learn from their share.

    Args:
        config: How to train.
        folder: Where the checkpoints lie; the first rank writes them.
        corpus: Questions labelled one by one, of the training split.
        progress: Told after each step.
        ranks: Which process this is, and where it trains.
        workers: Processes of the first rank that draw questions; 0 for itself.
        start: Folder of a reader to go on from, of this size, whatever language it wrote: it knows
            the words of questions already. None for random weights.

    Raises:
        UsageError: If a checkpoint belongs to another configuration, or the batch does not divide
            among the ranks.
    """
    ranks.refuse_uneven(config.batch)
    if start is None:
        tokenizer, lexicon = ranks.from_first(lambda: train_vocabulary(config, corpus))
        begun = None
    else:
        tokenizer, lexicon, begun = _begun(start, config)
    spelling = Spelling(tokenizer, lexicon=lexicon)
    shared = _Shared(spelling, corpus, ranks, workers, progress, begun)
    seeds = [seed_for(config.seed, "reading", "teacher", one) for one in range(config.teachers)]
    teachers = [
        _learned(f"teacher_{place}", replace(config, seed=seed), folder, shared)
        for place, seed in enumerate(seeds)
    ]
    if teachers:
        config = replace(
            config,
            steps=config.taught_steps,
            learning_rate=config.learning_rate / 2,
            hidden=2 * config.hidden,
            seed=seed_for(config.seed, "reading", "taught"),
        )
    model = _learned("reader", config, folder, shared, teachers)
    tokenizer.model.dropout = None
    return Reader(model.cpu(), shared.spelling, (1.0, 0.0))


def train_vocabulary(config: ReadingTraining, corpus: Sequence[Pair]) -> tuple[Tokenizer, Lexicon]:
    """Return byte pairs made from the texts of the training families, and their frequent words."""
    pairs = [*islice(grammar().pairs(config.seed, "train"), VOCABULARY_PAIRS), *corpus]
    texts = [part for pair in pairs for part in plain_parts(pair.text)]
    tokenizer = byte_pairs(texts, config.vocabulary)
    tokenizer.model.dropout = config.dropout
    return tokenizer, Lexicon.of(texts)


def _begun(start: Path, config: ReadingTraining):
    """Return byte pairs, frequent words, and the weights of a reader and the ids of its words."""
    stored = json.loads((start / "config.json").read_text(encoding="utf-8"))
    tokenizer = Tokenizer.from_file(str(start / "tokenizer.json"))
    tokenizer.model.dropout = config.dropout
    lexicon = Lexicon(tuple(stored["lexicon"].split()), int(stored["frequent_words"]))
    weights = {name: x.float() for name, x in load_file(start / "model.safetensors").items()}
    return tokenizer, lexicon, (weights, Spelling(tokenizer, tuple(stored["words"])).id_of)


def _take(
    model: QuestionDecoder, spelling: Spelling, weights: dict[str, Tensor], ids: dict[str, int]
) -> None:
    """Take another reader's weights; of the words of its language only those that this one has."""
    name = "decoder.embed_tokens.weight"
    own, others = model.state_dict()[name].clone(), weights[name]
    texts = spelling.tokenizer.get_vocab_size()
    own[:texts] = others[:texts]
    for word in spelling.id_of.keys() & ids.keys():
        own[spelling.id_of[word]] = others[ids[word]]
    model.load_state_dict(weights | {name: own})


def rate_at(step: int, config: ReadingTraining) -> float:
    """Return the learning rate of a step."""
    if step < config.warmup:
        return config.learning_rate * (step + 1) / config.warmup
    share = (step - config.warmup) / max(config.steps - config.warmup, 1)
    return config.learning_rate * 0.5 * (1 + math.cos(math.pi * share))


def _learned(
    name: str,
    config: ReadingTraining,
    folder: Path,
    shared: _Shared,
    teachers: Sequence[QuestionDecoder] = (),
) -> QuestionDecoder:
    """Return a model that learned from labels, or from teachers where there are any."""
    ranks = shared.ranks
    model = _fresh(config, shared.spelling.size)
    if shared.begun is not None:
        _take(model, shared.spelling, *shared.begun)
    if teachers:
        model.load_state_dict(teachers[0].state_dict())
    model.to(ranks.device)
    optimiser = Muon(orthogonal_groups(parameter_groups(model)), betas=(0.9, 0.98))
    path = folder / f"{name}_checkpoint.pt"
    step = _restored(path, config, model, optimiser)
    draws = _rows(config, shared, step)
    saved_at = time.monotonic()
    try:
        while step < config.steps:
            for group in optimiser.param_groups:
                group["lr"] = rate_at(step, config)
            hides = _generator(config.seed, "hidden", step)
            rows = ranks.from_first(lambda: next(draws))
            batch = batch_of(rows, config.hidden, hides, is_exchanged=bool(teachers))
            with uninterrupted_step():
                loss = _step(model, batch, optimiser, ranks, teachers)
                step += 1
            shared.progress(f"train {name}, loss {loss:.3f}", step, config.steps)
            if ranks.is_first and time.monotonic() - saved_at > CHECKPOINT_EVERY_S:
                _store(path, config, model, optimiser, step)
                saved_at = time.monotonic()
    finally:
        if ranks.is_first:
            _store(path, config, model, optimiser, step)
    return model.eval()


def _fresh(config: ReadingTraining, vocabulary: int) -> QuestionDecoder:
    with torch.random.fork_rng(devices=[]):  # torch draws what is drawn again below
        model = QuestionDecoder(config.size, vocabulary).train()
    initialise(model, config.size.layers, _generator(config.seed, "weights"))
    return model


def _rows(config: ReadingTraining, shared: _Shared, step: int) -> Iterator[list[Row]]:
    """Yield the rows of each step from one on; nothing is drawn before the first is asked for."""
    room = config.size.max_tokens
    drawing = Drawing(
        shared.spelling, shared.corpus, config.batch, config.corpus_share, room, config.seed
    )
    return rows_from(drawing, step, shared.workers)


def _step(
    model: QuestionDecoder,
    batch: Batch,
    optimiser: torch.optim.Optimizer,
    ranks: Ranks,
    teachers: Sequence[QuestionDecoder] = (),
) -> float:
    """Learn from this rank's share of the rows; return the loss of all."""
    per_rank = batch.is_query.sum().item() / ranks.count
    optimiser.zero_grad(set_to_none=True)
    mine = Batch(*(ranks.share(one).to(ranks.device) for one in batch))
    total = 0.0
    if len(mine.ids):
        with ranks.bfloat16_products():
            loss = _loss(model, mine, teachers)
        (loss / per_rank).backward()
        total = loss.item()
    told = ranks.average(model.parameters(), total / per_rank)
    torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
    optimiser.step()
    return told


def _loss(model: QuestionDecoder, batch: Batch, teachers: Sequence[QuestionDecoder]) -> Tensor:
    """Return the summed cross entropy of the query's tokens, in nats."""
    wanted = batch.ids[batch.is_query]
    spare = rounded(len(wanted), 64) - len(wanted)
    logits = _logits(model, batch, spare)
    if not teachers:
        wanted = pad(wanted, (0, spare), value=-1)
        return cross_entropy(logits, wanted, reduction="sum", ignore_index=-1)
    with torch.no_grad():
        told = sum(_logits(one, batch, spare).softmax(-1) for one in teachers) / len(teachers)
        is_light = batch.is_light.expand_as(batch.is_query)[batch.is_query]
        labels = one_hot(wanted, logits.shape[-1]) * (LABEL * is_light[:, None])
        told = told[: len(wanted)] + labels
    return cross_entropy(logits[: len(wanted)], told, reduction="sum")


def _logits(model: QuestionDecoder, batch: Batch, spare: int) -> Tensor:
    """Return the logits of the query's tokens and of `spare` more, (tokens, ids)."""
    embedded = model.decoder.embed_tokens(batch.shown)
    kept = batch.is_seen | batch.is_query
    states = model.decoder(embedded * kept[..., None], batch.mask)
    before = states[:, :-1][batch.is_query[:, 1:]]
    return model.logits(pad(before, (0, 0, 0, spare))).float()


def _generator(seed: int, *names: str | int) -> torch.Generator:
    return torch.Generator().manual_seed(seed_for(seed, "reading", *names))


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
