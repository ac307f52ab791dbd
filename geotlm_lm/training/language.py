"""Train the language model: English, what questions mean, what is felt in clips, and sentences.

Each stage goes on from the weights of the one before and from its own last checkpoint. The last two
leave how questions are read exactly as it was: they teach the projector what is felt, and the
layers above those that read what is said of it. Two runs of one seed are alike, not equal: see
`language_rows`.
"""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import count, islice
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any

import torch
from tokenizers import Tokenizer
from torch import Tensor
from torch.nn.functional import cross_entropy, pad

from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.language.decoder import LanguageModel, fresh, served, stored, with_speaking
from geotlm_lm.language.size import LanguageSize
from geotlm_lm.language.tokenizer import byte_pairs
from geotlm_lm.motion.belief import BELIEF_NUMBERS
from geotlm_lm.query.program import MOST_SLOTS
from geotlm_lm.query.quantities import find
from geotlm_lm.query.reader import (
    SLOT_TOKENS,
    SPELLING_FILE,
    WORDS,
    Lexicon,
    Reader,
    Spelling,
    cleaned_text,
    slipped_from,
    spelled_by,
)
from geotlm_lm.training.calibration import best_share
from geotlm_lm.training.fit import fit
from geotlm_lm.training.forms import formed
from geotlm_lm.training.grammar import Pair, grammar
from geotlm_lm.training.labelled import KEPT, TUNE, labelled
from geotlm_lm.training.language_rows import (
    POOL,
    SENTENCE,
    Answers,
    Batch,
    Clips,
    Questions,
    hidden,
    in_parts,
    positions,
    rounded,
    sight,
    steps_from,
)
from geotlm_lm.training.muon import Muon
from geotlm_lm.training.ranks import ALONE, Ranks
from geotlm_lm.training.truth import UNASKED

if TYPE_CHECKING:
    from geotlm_lm.training.sentences import Sentences

VOCABULARY_PAIRS = 60_000
"""Texts that the vocabulary of byte pairs is made from, and at most as many passages."""

WEIGHT_DECAY = 0.1
"""Of the matrices; gains, biases and embeddings are left alone."""

LEARNING_RATE = 3e-3
"""Peak of each stage; rises over the steps of `warmup` and falls to nothing as a cosine. What reads
already and learns on has half of it."""

HIDDEN = 0.06
"""Mean share of a question's tokens that are hidden; each question's own is between none and twice
this."""

CORPUS_SHARE, COMPOSED_SHARE, FORMS_SHARE = 0.5, 0.1, 0.1
"""Shares of questions drawn from the corpus instead of the grammar, half of them with the grammar's
clauses around, of programs composed at random, and of questions for an output of a given form."""

NOISE = 0.2
"""Deviation of the noise on the fused token, in units of its spread over the training clips:
without it a clip can be learned by heart. The belief is a measurement with its own spread."""

SILENT_SHARE = 0.15
"""Share of clips of which the belief is not shown, so that the fused token is read as well."""

STAGES = ("english", "reading", "slots", "sentences")

BESIDE = 0.1
"""Weight of English beside questions: a passage's words stay hard to guess, and would drown what
questions have left to learn."""


@dataclass(frozen=True)
class LanguageTraining:
    """How the language model is trained.

    Args:
        english_steps: Steps of the first stage, on English alone.
        reading_steps: Steps of the second, on questions and their programs.
        slots_steps: Steps of the third, on what is felt in clips.
        sentences_steps: Steps of the fourth, on answers about clips.
        batch: Questions a step, or passages of English, of which a quarter comes beside questions;
            half as many answers about clips, or twice as many clips alone.
        warmup: Steps over which the learning rate rises.
        dropout: Share of byte pairs that are left apart.
        passes: How often each question drawn is learned from, words hidden anew.
        vocabulary: Byte pairs at most.
        seed: Of weights and draws.
        size: How large the model is.
    """

    english_steps: int = 2_000
    reading_steps: int = 7_000
    slots_steps: int = 2_000
    sentences_steps: int = 3_000
    batch: int = 128
    warmup: int = 300
    dropout: float = 0.1
    passes: int = 1
    vocabulary: int = 4000
    seed: int = 0
    size: LanguageSize = field(default_factory=LanguageSize)


@dataclass(frozen=True)
class Taught:
    """What a language model learns from.

    Args:
        corpus: Questions labelled one by one, of the training split.
        passages: English; none skips that stage.
        sentences: Answers about clips; none skips that stage.
        widths: Of a clip's fused token and of its belief.
        start: Folder of a language model to go on from, of its size, whatever programs it wrote.
            None for random weights.
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

    Goes on from the checkpoints in `folder`, one a stage. The first rank draws and spells each
    step's rows, whose byte pairs no seed governs, and all learn from their share.

    Args:
        config: How to train.
        taught: What from.
        folder: Where the checkpoints lie; the first rank writes them.
        progress: Shown each step.
        ranks: Which process this is, and where it trains.
        workers: Processes of the first rank that draw questions; 0 for itself.

    Raises:
        UsageError: If the checkpoint belongs to another configuration, or a batch does not divide
            among the ranks.
    """
    ranks.refuse_uneven(config.batch, config.batch // 2)
    if (folder / "language" / SPELLING_FILE).exists():
        return folder / "language"
    spelling = ranks.from_first(lambda: _spelling(config, taught, folder))
    model = _begun(config, taught, spelling)
    taught_by = {
        "english": taught.passages,
        "reading": True,
        "slots": taught.sentences,
        "sentences": taught.sentences and config.size.speaking,
    }
    for name in STAGES:
        if name == "sentences":
            model = with_speaking(model, config.size.speaking, _generator(config.seed, "above"))
        stage = _Stage(name, config, taught, spelling, ranks, workers, progress)
        if stage.steps and taught_by[name]:
            model = model.to(ranks.device).train()
            stage.train(model, folder)
            if name == "reading" and taught.start is not None:
                _blend(model, _begun(config, taught, spelling), spelling, folder, ranks)
    spelling.tokenizer.model.dropout = None
    if ranks.is_first:
        Reader(served(model.cpu()), spelling, (1.0, 0.0)).save(folder / "language")
    return folder / "language"


def blank_reader(token_width: int) -> Reader:
    """Return a language model that has learned nothing, for a bundle that only sees."""
    spelling = Spelling(byte_pairs(["which way?"], 256))
    size, widths = LanguageSize(16, 1, 1, 16, speaking=0), (token_width, BELIEF_NUMBERS)
    model = fresh(size, spelling.size, widths, _generator(0, "blank"))
    return Reader(served(model), spelling, (1.0, 0.0))


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
        return getattr(self.config, f"{self.name}_steps")

    def train(self, model: LanguageModel, folder: Path) -> None:
        """Take the steps that are left of those behind the stage's checkpoint."""
        ranks, draws = self.ranks, None
        if self.name == "slots":
            model.projector.standardise_by(torch.from_numpy(self.taught.sentences.numbers).float())
        optimiser = self._optimiser(model)

        def step(number: int) -> str:
            nonlocal draws
            draws = draws or self._batches(number)
            for group in optimiser.param_groups:
                group["lr"] = self.rate_at(number)
            batches = ranks.from_first(lambda: next(draws))
            loss = self._step(model, batches, optimiser, number)
            return f"language, {self.name}, loss {loss:.3f}"

        fit(
            step,
            self.steps,
            {"model": model, "optimiser": optimiser},
            path=folder / f"language_{self.name}.pt",
            about=asdict(self.config),
            ranks=ranks,
            progress=self.progress,
        )

    def _optimiser(self, model: LanguageModel) -> Muon:
        """Return that of what this stage teaches; all else keeps still."""
        learned = dict(model.named_parameters())
        if self.name == "slots":
            learned = {name: x for name, x in learned.items() if name.startswith("projector")}
            learned["llama.model.embed_tokens.weight"] = model.embed_weight()
            slots = [self.spelling.id_of[token] for token in SLOT_TOKENS]
            is_slot = torch.zeros(len(model.embed_weight()), 1).to(model.embed_weight())
            is_slot[slots] = 1
            model.embed_weight().register_hook(lambda gradient: gradient * is_slot)
        elif self.name == "sentences":
            learned = {name: x for name, x in learned.items() if name.startswith("projector")}
            learned |= model.speaking_parameters()
        for name, weight in model.named_parameters():
            weight.requires_grad_(name in learned)
        matrices, others = [], []
        for name, weight in learned.items():
            is_matrix = weight.ndim == 2 and "embed_tokens" not in name
            (matrices if is_matrix else others).append(weight)
        groups = [
            {"params": matrices, "weight_decay": WEIGHT_DECAY, "is_orthogonal": True},
            {"params": others, "weight_decay": 0.0},
        ]
        return Muon(groups, betas=(0.9, 0.98))

    def rate_at(self, step: int) -> float:
        """Return the learning rate of a step."""
        warmup = min(self.config.warmup, self.steps // 4)
        goes_on = self.name == "reading" and self.taught.start is not None
        peak = LEARNING_RATE / 2 if goes_on else LEARNING_RATE
        if step < warmup:
            return peak * (step + 1) / warmup
        share = (step - warmup) / max(self.steps - warmup, 1)
        return peak * 0.5 * (1 + math.cos(math.pi * share))

    def _batches(self, step: int) -> Iterator[list[Batch]]:
        """Yield each step's batches; nothing is drawn before the first is asked for."""
        config, is_english = self.config, self.name == "english"
        if self.name in ("slots", "sentences"):
            yield from self._about_clips(step)
        drawing = Questions(
            self.spelling,
            self.taught.corpus,
            0 if is_english else config.batch,
            CORPUS_SHARE,
            COMPOSED_SHARE,
            FORMS_SHARE,
            self.taught.passages,
            config.batch if is_english else config.batch // 4,
            config.size.max_tokens,
            seed_for(config.seed, "language", self.name),
        )
        yield from steps_from(drawing, step, self.workers, config.passes)

    def _about_clips(self, step: int) -> Iterator[list[Batch]]:
        """Yield each step's batch of clips alone, or of answers about them."""
        rows, size = Clips(self.taught.sentences, self.spelling), 2 * self.config.batch
        if self.name == "sentences":
            rows, size = Answers(self.taught.sentences, self.spelling), self.config.batch // 2
        first, skipped = divmod(step, POOL)
        for pool in count(first):
            rng = generator_for(self.config.seed, "language", self.name, pool)
            yield from ([part] for part in rows.pool(rng, size)[skipped:])
            skipped = 0

    def _step(
        self, model: LanguageModel, batches: list[Batch], optimiser: Muon, step: int
    ) -> float:
        """Learn from this rank's share of the rows; return the loss of all."""
        config, ranks = self.config, self.ranks
        # Gradients of an earlier stage would count in the norm, and not after an interruption.
        model.zero_grad(set_to_none=True)
        total = 0.0
        for place, batch in enumerate(batches):
            draws = _generator(config.seed, self.name, "hidden", step, place)
            is_hidden, wanted = hidden(batch, HIDDEN, draws)
            prefix = self._prefix(model, batch, draws)
            asked = max(int((wanted != UNASKED).sum()), 1) / ranks.count
            asked /= BESIDE if place else 1
            mine = Batch(*map(ranks.share, batch._replace(wanted=wanted)))
            for part, rows in in_parts(mine, ranks.kind):
                shown = ranks.share(is_hidden)[rows, : part.ids.shape[1]]
                seen = None if prefix is None else prefix[rows]
                with ranks.bfloat16_products():
                    loss = _loss(model, part, shown, seen, ranks.device)
                (loss / asked).backward()
                total += loss.item() / asked
        total = ranks.average(model.parameters(), total)
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimiser.step()
        return total

    def _prefix(self, model: LanguageModel, batch: Batch, draws: torch.Generator) -> Tensor | None:
        """Return the standardised numbers of this rank's clips, the fused token's with noise."""
        if int(batch.clip[0]) == UNASKED:
            return None
        numbers = torch.from_numpy(self.taught.sentences.numbers[batch.clip.numpy()]).float()
        token_width = model.projector.widths[0]
        noise = NOISE * torch.randn((len(numbers), token_width), generator=draws)
        # Sentences are of the belief: they could not be learned from the fused token.
        share = SILENT_SHARE if self.name == "slots" else 0.0
        is_silent = torch.rand(len(numbers), generator=draws) < share
        mean, scale = model.projector.mean.cpu(), model.projector.scale.cpu()
        numbers = (numbers - mean) / scale
        numbers[:, :token_width] += noise
        numbers[is_silent, token_width:] = 0
        return self.ranks.share(numbers)


def _loss(
    model: LanguageModel, batch: Batch, is_hidden: Tensor, prefix: Tensor | None, device: str
) -> Tensor:
    """Return the summed cross entropy of what is wanted, in nats."""
    batch = Batch(*(each.to(device, non_blocking=True) for each in batch))
    is_wanted = batch.wanted != UNASKED
    asked = int(is_wanted.sum())
    spare = rounded(asked, 64) - asked
    labels = pad(batch.wanted[is_wanted], (0, spare), value=UNASKED)
    embedded = model.embed(batch.ids) * ~is_hidden.to(device)[..., None]
    if prefix is not None:
        made = model.projector.from_standardised(prefix.to(embedded.device)).to(embedded.dtype)
        embedded = torch.cat([made, embedded[:, made.shape[1] :]], dim=1)
    read, spoken = model.states(embedded, sight(batch.kind), positions(batch.kind))
    states = torch.where((batch.kind == SENTENCE)[..., None], spoken, read)
    logits = model.logits(pad(states[is_wanted], (0, 0, 0, spare))).float()
    return cross_entropy(logits, labels, reduction="sum", ignore_index=UNASKED)


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
    shown = formed(Random(config.seed), "train")
    pairs = [
        *islice(grammar().pairs(config.seed, "train"), VOCABULARY_PAIRS),
        *islice(shown, VOCABULARY_PAIRS // 10),
        *corpus,
    ]
    texts = [part for pair in pairs for part in _plain_parts(pair.text)]
    lexicon = lexicon_of(texts)
    texts += list(passages[: VOCABULARY_PAIRS // 2])
    return byte_pairs(texts, config.vocabulary), WORDS, lexicon


def _begun(config: LanguageTraining, taught: Taught, spelling: Spelling) -> LanguageModel:
    """Return a model of random weights, or one that goes on from another's."""
    weights = _generator(config.seed, "weights")
    if taught.start is None:
        return fresh(replace(config.size, speaking=0), spelling.size, taught.widths, weights)
    before, (other, _) = stored(taught.start), spelled_by(taught.start)
    size = replace(before.size, speaking=0)
    model = fresh(size, spelling.size, taught.widths, weights)
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


def _blend(
    model: LanguageModel, before: LanguageModel, spelling: Spelling, folder: Path, ranks: Ranks
) -> None:
    """Replace a model's weights by their best mean with those that it began with."""
    later = {name: x.detach().cpu().clone() for name, x in model.state_dict().items()}
    former, path = before.state_dict(), folder / "language_share.json"
    plain = Spelling(Tokenizer.from_str(spelling.tokenizer.to_str()), lexicon=spelling.lexicon)
    plain.tokenizer.model.dropout = None

    def mean(share: float) -> dict[str, Tensor]:
        return {name: torch.lerp(former[name], x, share) for name, x in later.items()}

    def reader_of(share: float) -> Reader:
        before.load_state_dict(mean(share))
        return Reader(served(before), plain, (1.0, 0.0))

    def chosen() -> float:
        if not path.exists():
            share, read = best_share(reader_of, labelled(TUNE) + labelled(KEPT))
            write_text_atomically(path, json.dumps({"share": share, "read": read}))
        return json.loads(path.read_text(encoding="utf-8"))["share"]

    former = {name: x.clone() for name, x in former.items()}
    model.load_state_dict(mean(ranks.from_first(chosen)))


def _generator(seed: int, *names: str | int) -> torch.Generator:
    return torch.Generator().manual_seed(seed_for(seed, "language", *names))


def _plain_parts(text: str) -> list[str]:
    """Return what of a text is read as byte pairs: all but its numbers."""
    ends = [(each.start, each.end) for each in find(text)[:MOST_SLOTS]]
    starts = [0, *(end for _, end in ends)]
    stops = [*(start for start, _ in ends), len(text)]
    return [cleaned_text(text[a:b]) for a, b in zip(starts, stops, strict=True)]


LEAST, FREQUENT = 10, 40
"""How often a known word stands in the texts a lexicon is made of, and one that is mended to."""

SLIPS = 100
"""How much rarer than the word it is a slip of a slip is: texts made to be read hold some."""


def lexicon_of(texts: Iterable[str]) -> Lexicon:
    """Return the frequent words of some texts, in whose favour slips of the fingers are mended."""
    words = re.compile(r"[^\W\d_]+")
    counts = Counter(word for text in texts for word in words.findall(text.lower()))
    known = [
        (word, count)
        for word, count in counts.most_common()
        if count >= LEAST
        and not any(counts[meant] >= SLIPS * count for meant in slipped_from(word))
    ]
    frequent = sum(count >= FREQUENT for _, count in known)
    return Lexicon(tuple(word for word, _ in known), frequent)
