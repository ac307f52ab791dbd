"""Train the language model: first English, then what questions mean, then to answer about clips.

Each stage goes on from the weights of the one before and from its own last checkpoint. In the last
one the weights before teach how questions are read, beside their labels, so that nothing learned is
lost (learning without forgetting, Li and Hoiem 2016). Two runs of one seed are alike, not
equal: see `language_rows`.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass, field
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import torch
from tokenizers import Tokenizer
from torch import Tensor
from torch.nn.functional import cross_entropy, pad

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.core.process import Progress, silent, uninterrupted_step
from geotlm_lm.language.decoder import LanguageModel, fresh, served, stored
from geotlm_lm.language.size import LanguageSize
from geotlm_lm.language.tokenizer import byte_pairs
from geotlm_lm.motion.network import BELIEF_NUMBERS
from geotlm_lm.query.grammar import Pair, grammar
from geotlm_lm.query.lexicon import Lexicon
from geotlm_lm.query.reader import SPELLING_FILE, Reader, spelled_by
from geotlm_lm.query.spelling import WORDS, Spelling, plain_parts
from geotlm_lm.training.fit import load_checkpoint, save_checkpoint
from geotlm_lm.training.language_rows import (
    POOL,
    SLOT,
    Answers,
    Batch,
    Questions,
    hidden,
    positions,
    rounded,
    sight,
    steps_from,
)
from geotlm_lm.training.muon import Muon, orthogonal_groups
from geotlm_lm.training.ranks import ALONE, Ranks
from geotlm_lm.training.truth import UNASKED

if TYPE_CHECKING:
    from geotlm_lm.training.sentences import Sentences

CHECKPOINT_EVERY_S = 60.0
VOCABULARY_PAIRS = 60_000
"""Texts that the vocabulary of byte pairs is made from, and at most as many passages."""

WEIGHT_DECAY = 0.1
"""Of the matrices; gains, biases and embeddings are left alone."""

NOISE = 0.2
"""Deviation of the noise on the fused token, in units of its spread over the training clips:
without it a clip can be learned by heart. The belief is a measurement with its own spread."""

SILENT_SHARE = 0.15
"""Share of clips of which the belief is not shown, so that the fused token is read as well."""

FELT = 4.0
"""Weight of a word at a slot against 1 for a token of a sentence: there are four, and they are what
is held beside other ways to name a motion."""

STAGES = ("english", "reading", "answers")

BESIDE = 0.1
"""Weight of English beside questions: a passage's words stay hard to guess, and would drown what
questions have left to learn."""

ANSWERS = 0.5
"""Weight of answers beside questions."""

LABEL = 0.25
"""Weight of a program's label beside what the weights before answers make of a question."""


@dataclass(frozen=True)
class LanguageTraining:
    """How the language model is trained.

    Args:
        english_steps: Steps of the first stage, on English alone.
        reading_steps: Steps of the second, on questions and their programs.
        answers_steps: Steps of the third, on questions and on answers about clips.
        batch: Questions a step.
        english: Passages a step; a quarter of them beside questions.
        answers: Answers about clips a step.
        learning_rate: Peak of each stage; rises over `warmup` steps and falls to nothing as a
            cosine. A third of it for answers.
        warmup: Steps of the rise.
        hidden: Mean share of a question's tokens that are hidden; each question's own is between
            none and twice this.
        dropout: Share of byte pairs that are left apart.
        corpus_share: Share of questions drawn from the corpus instead of the grammar, half of them
            with the grammar's clauses around.
        composed_share: Share of programs composed at random.
        passes: How often each question drawn is learned from, words hidden anew.
        vocabulary: Byte pairs at most.
        seed: Of weights and draws.
        size: How large the model is.
    """

    english_steps: int = 2_000
    reading_steps: int = 7_000
    answers_steps: int = 1_500
    batch: int = 128
    english: int = 128
    answers: int = 128
    learning_rate: float = 3e-3
    warmup: int = 300
    hidden: float = 0.06
    dropout: float = 0.1
    corpus_share: float = 0.2
    composed_share: float = 0.1
    passes: int = 1
    vocabulary: int = 4000
    seed: int = 0
    size: LanguageSize = field(default_factory=LanguageSize)

    def steps_of(self, stage: str) -> int:
        """Return how many steps a stage has."""
        return getattr(self, f"{stage}_steps")


@dataclass(frozen=True)
class Taught:
    """What a language model learns from.

    Args:
        corpus: Questions labelled one by one, of the training split.
        passages: English; none skips that stage.
        sentences: Answers about clips; none skips that stage.
        widths: Of a clip's fused token and of its belief.
        start: Folder of a language model to go on from, whatever programs it wrote. None for
            random weights.
    """

    corpus: Sequence[Pair]
    passages: Sequence[str] = ()
    sentences: Sentences | None = None
    widths: tuple[int, int] = (0, BELIEF_NUMBERS)
    start: Path | None = None


def train_language(
    config: LanguageTraining,
    taught: Taught,
    folder: Path,
    progress: Progress = silent,
    ranks: Ranks = ALONE,
    workers: int = 0,
) -> Path:
    """Train a language model, not yet calibrated; return its folder, `folder`/language.

    Goes on from the checkpoint in `folder`. The first rank draws and spells each step's rows, whose
    byte pairs no seed governs, and all learn from their share.

    Args:
        config: How to train.
        taught: What from.
        folder: Where the checkpoint lies; the first rank writes it.
        progress: Shown each step.
        ranks: Which process this is, and where it trains.
        workers: Processes of the first rank that draw questions; 0 for itself.

    Raises:
        UsageError: If the checkpoint belongs to another configuration, or a batch does not divide
            among the ranks.
    """
    ranks.refuse_uneven(config.batch, config.english, config.answers)
    if (folder / "language" / SPELLING_FILE).exists():
        return folder / "language"
    spelling = ranks.from_first(lambda: _spelling(config, taught, folder))
    model = _begun(config, taught, spelling).to(ranks.device).train()
    optimiser = Muon(orthogonal_groups(parameter_groups(model)), betas=(0.9, 0.98))
    stage, step = _restored(folder, config, model, optimiser)
    for name in STAGES[STAGES.index(stage) :]:
        begin = step if name == stage else 0
        if _is_taught(name, taught):
            run = _Stage(name, config, taught, spelling, ranks, workers, progress)
            run.train(model, optimiser, begin, folder)
    spelling.tokenizer.model.dropout = None
    if ranks.is_first:
        Reader(served(model.cpu()), spelling, (1.0, 0.0)).save(folder / "language")
    return folder / "language"


def blank_reader(token_width: int) -> Reader:
    """Return a language model that has learned nothing, for a bundle that only sees."""
    spelling = Spelling(byte_pairs(["which way?"], 256))
    size, widths = LanguageSize(16, 1, 1, 16), (token_width, BELIEF_NUMBERS)
    model = fresh(size, spelling.size, widths, _generator(0, "blank"))
    return Reader(served(model), spelling, (1.0, 0.0))


def _is_taught(stage: str, taught: Taught) -> bool:
    needed = {"english": taught.passages, "reading": True, "answers": taught.sentences}
    return bool(needed[stage])


@dataclass(frozen=True)
class _Stage:
    """One stage of a training."""

    name: str
    config: LanguageTraining
    taught: Taught
    spelling: Spelling
    ranks: Ranks
    workers: int
    progress: Progress

    @property
    def steps(self) -> int:
        return self.config.steps_of(self.name)

    def train(self, model: LanguageModel, optimiser: Muon, step: int, folder: Path) -> None:
        """Take the steps that are left from `step` on."""
        config, ranks = self.config, self.ranks
        if self.name == "answers" and not step:
            model.projector.standardise_by(torch.from_numpy(self.taught.sentences.numbers).float())
        before = self._before(model, folder) if self.name == "answers" else None
        draws = self._batches(step)
        saved_at = time.monotonic()
        try:
            while step < self.steps:
                for group in optimiser.param_groups:
                    group["lr"] = self.rate_at(step)
                batches = ranks.from_first(lambda: next(draws))
                with uninterrupted_step():
                    loss = self._step(model, batches, optimiser, step, before)
                    step += 1
                self.progress(f"language, {self.name}, loss {loss:.3f}", step, self.steps)
                if ranks.is_first and time.monotonic() - saved_at > CHECKPOINT_EVERY_S:
                    _save(folder, config, model, optimiser, self.name, step)
                    saved_at = time.monotonic()
        finally:
            if ranks.is_first:
                _save(folder, config, model, optimiser, self.name, step)

    def _before(self, model: LanguageModel, folder: Path) -> LanguageModel:
        """Return the model as it was before this stage, which the first rank keeps in `folder`."""
        path = folder / "before_answers.pt"
        kept = self.ranks.from_first(lambda: load_checkpoint(path))
        if kept is None:
            kept = {name: weights.cpu().clone() for name, weights in model.state_dict().items()}
            if self.ranks.is_first:
                save_checkpoint(path, kept)
        before = deepcopy(model).eval().requires_grad_(False)
        before.load_state_dict(kept)
        return before

    def rate_at(self, step: int) -> float:
        """Return the learning rate of a step."""
        config = self.config
        peak = config.learning_rate / (3 if self.name == "answers" else 1)
        warmup = min(config.warmup, self.steps // 4)
        if step < warmup:
            return peak * (step + 1) / warmup
        share = (step - warmup) / max(self.steps - warmup, 1)
        return peak * 0.5 * (1 + math.cos(math.pi * share))

    def _batches(self, step: int) -> Iterator[list[Batch]]:
        """Yield each step's batches; nothing is drawn before the first is asked for."""
        config, is_english = self.config, self.name == "english"
        drawing = Questions(
            self.spelling,
            self.taught.corpus,
            0 if is_english else config.batch,
            config.corpus_share,
            config.composed_share,
            self.taught.passages,
            config.english if is_english else config.english // 4,
            config.size.max_tokens,
            seed_for(config.seed, "language", self.name),
        )
        drawn = steps_from(drawing, step, self.workers, config.passes)
        if self.name != "answers":
            yield from drawn
        answers, made, parts = Answers(self.taught.sentences, self.spelling), -1, []
        for place, batches in enumerate(drawn, step):
            pool, part = divmod(place, POOL)
            if pool != made:
                rng = generator_for(config.seed, "language", "answers", pool)
                made, parts = pool, answers.pool(rng, config.answers)
            yield [*batches, parts[part]]

    def _step(
        self,
        model: LanguageModel,
        batches: list[Batch],
        optimiser: Muon,
        step: int,
        before: LanguageModel | None = None,
    ) -> float:
        """Learn from this rank's share of the rows; return the loss of all."""
        config, ranks = self.config, self.ranks
        optimiser.zero_grad(set_to_none=True)
        total = 0.0
        for place, batch in enumerate(batches):
            draws = _generator(config.seed, self.name, "hidden", step, place)
            is_hidden, wanted = hidden(batch, config.hidden, draws)
            prefix = self._prefix(model, batch, draws)
            asked = max(int((wanted != UNASKED).sum()), 1) / ranks.count
            asked /= self._weights()[place]
            mine = Batch(*map(ranks.share, batch._replace(wanted=wanted)))
            if len(mine.ids):
                teacher = None if place else before
                with ranks.bfloat16_products():
                    shown = ranks.share(is_hidden), prefix, ranks.device
                    loss = _loss(model, mine, *shown, teacher)
                (loss / asked).backward()
                total += loss.item() / asked
        total = ranks.average(model.parameters(), total)
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimiser.step()
        return total

    def _weights(self) -> tuple[float, ...]:
        """Return the weights of a step's batches, in their order."""
        if self.name == "english":
            return (1.0,)
        return (1.0, *[BESIDE] * bool(self.taught.passages), ANSWERS)

    def _prefix(self, model: LanguageModel, batch: Batch, draws: torch.Generator) -> Tensor | None:
        """Return the standardised numbers of this rank's clips, the fused token's with noise."""
        if int(batch.clip[0]) == UNASKED:
            return None
        numbers = torch.from_numpy(self.taught.sentences.numbers[batch.clip.numpy()]).float()
        token_width = model.projector.widths[0]
        noise = NOISE * torch.randn((len(numbers), token_width), generator=draws)
        is_silent = torch.rand(len(numbers), generator=draws) < SILENT_SHARE
        mean, scale = model.projector.mean.cpu(), model.projector.scale.cpu()
        numbers = (numbers - mean) / scale
        numbers[:, :token_width] += noise
        numbers[is_silent, token_width:] = 0
        return self.ranks.share(numbers)


def _loss(
    model: LanguageModel,
    batch: Batch,
    is_hidden: Tensor,
    prefix: Tensor | None,
    device: str,
    before: LanguageModel | None = None,
) -> Tensor:
    """Return the summed cross entropy of what is wanted, in nats; of what `before` makes of it."""
    batch = Batch(*(each.to(device, non_blocking=True) for each in batch))
    is_wanted = batch.wanted != UNASKED
    count = int(is_wanted.sum())
    spare = rounded(count, 64) - count
    labels = pad(batch.wanted[is_wanted], (0, spare), value=UNASKED)
    given = batch, is_hidden.to(device), prefix, is_wanted, spare
    logits = _logits(model, *given)
    costs = cross_entropy(logits, labels, reduction="none", ignore_index=UNASKED)
    if before is not None:
        with torch.no_grad():
            likely = _logits(before, *given).softmax(-1)
        taught = -(likely * logits.log_softmax(-1)).sum(-1)
        costs = (taught + LABEL * costs) / (1 + LABEL)
    weights = torch.where(batch.kind == SLOT, FELT, 1.0)[is_wanted]
    return (costs[:count] * weights).sum()


def _logits(
    model: LanguageModel,
    batch: Batch,
    is_hidden: Tensor,
    prefix: Tensor | None,
    is_wanted: Tensor,
    spare: int,
) -> Tensor:
    """Return the logits of the states of which something is wanted and of `spare` more."""
    embedded = model.embed(batch.ids) * ~is_hidden[..., None]
    if prefix is not None:
        made = model.projector.from_standardised(prefix.to(embedded.device)).to(embedded.dtype)
        embedded = torch.cat([made, embedded[:, made.shape[1] :]], dim=1)
    states = model.states(embedded, sight(batch.kind), positions(batch.kind))
    return model.logits(pad(states[is_wanted], (0, 0, 0, spare))).float()


def _spelling(config: LanguageTraining, taught: Taught, folder: Path) -> Spelling:
    """Return byte pairs and frequent words: those of a model to go on from, or made of texts."""
    if taught.start is not None:
        before, _ = spelled_by(taught.start)
        spelling = Spelling(before.tokenizer, lexicon=before.lexicon)
    elif (folder / "vocabulary.json").exists():
        rows = json.loads((folder / "vocabulary.json").read_text(encoding="utf-8"))
        lexicon = Lexicon(tuple(rows["lexicon"]), rows["frequent"])
        spelling = Spelling(Tokenizer.from_str(rows["tokenizer"]), lexicon=lexicon)
    else:
        spelling = Spelling(*train_vocabulary(config, taught.corpus, taught.passages))
        folder.mkdir(parents=True, exist_ok=True)
        rows = {"tokenizer": spelling.tokenizer.to_str(), "lexicon": spelling.lexicon.words}
        rows["frequent"] = spelling.lexicon.frequent
        write_text_atomically(folder / "vocabulary.json", json.dumps(rows))
    spelling.tokenizer.model.dropout = config.dropout
    return spelling


def train_vocabulary(
    config: LanguageTraining, corpus: Sequence[Pair], passages: Sequence[str] = ()
) -> tuple[Any, tuple[str, ...], Lexicon]:
    """Return byte pairs made from questions and English, program words, and frequent words."""
    pairs = [*islice(grammar().pairs(config.seed, "train"), VOCABULARY_PAIRS), *corpus]
    texts = [part for pair in pairs for part in plain_parts(pair.text)]
    lexicon = Lexicon.of(texts)
    texts += list(passages[: VOCABULARY_PAIRS // 2])
    return byte_pairs(texts, config.vocabulary), WORDS, lexicon


def _begun(config: LanguageTraining, taught: Taught, spelling: Spelling) -> LanguageModel:
    """Return a model of random weights, or one that goes on from another's."""
    weights = _generator(config.seed, "weights")
    model = fresh(config.size, spelling.size, taught.widths, weights)
    if taught.start is None:
        return model
    before, (other, _) = stored(taught.start), spelled_by(taught.start)
    own, others = model.embed_weight().data.clone(), before.embed_weight().data
    texts = spelling.tokenizer.get_vocab_size()
    own[:texts] = others[:texts]
    for word in spelling.id_of.keys() & other.id_of.keys():
        own[spelling.id_of[word]] = others[other.id_of[word]]
    state = before.llama.state_dict()
    state = {name: x for name, x in state.items() if x.shape != others.shape}
    model.llama.load_state_dict(state, strict=False)
    model.embed_weight().data.copy_(own)
    if before.projector.widths == model.projector.widths:
        model.projector.load_state_dict(before.projector.state_dict())
    return model


def parameter_groups(model: torch.nn.Module) -> list[dict]:
    """Return the weights for their optimiser: the matrices decay, the others do not."""
    named = list(model.named_parameters())
    decayed = [p for n, p in named if p.ndim == 2 and "embed_tokens" not in n]
    plain = [p for n, p in named if p.ndim < 2 or "embed_tokens" in n]
    return [
        {"params": decayed, "weight_decay": WEIGHT_DECAY},
        {"params": plain, "weight_decay": 0.0},
    ]


def _generator(seed: int, *names: str | int) -> torch.Generator:
    return torch.Generator().manual_seed(seed_for(seed, "language", *names))


def _save(folder: Path, config, model, optimiser, stage: str, step: int) -> None:
    state = {"config": asdict(config), "stage": stage, "step": step, "model": model.state_dict()}
    save_checkpoint(folder / "language.pt", state | {"optimiser": optimiser.state_dict()})


def _restored(folder: Path, config, model, optimiser) -> tuple[str, int]:
    state = load_checkpoint(folder / "language.pt")
    if state is None:
        return STAGES[0], 0
    if state["config"] != asdict(config):
        raise UsageError(
            f"{folder / 'language.pt'}: was trained with other settings; delete it to start over, "
            f"or train into another folder."
        )
    model.load_state_dict(state["model"])
    optimiser.load_state_dict(state["optimiser"])
    return str(state["stage"]), int(state["step"])
