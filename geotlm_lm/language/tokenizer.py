"""A byte-level BPE tokenizer trained on the template corpus; knows text only.

Digits stay single, so that numbers are spelled and never guessed whole; every byte has a token, so
that no question is unreadable.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import chain

from tokenizers import Tokenizer, decoders, models, pre_tokenizers, trainers

from geotlm_lm.language.slots import SLOT_TOKENS, SLOT_WORDS, SLOTS

PAD, EOS, TACTILE, USER, ASSISTANT = "<pad>", "<eos>", "<tactile>", "<user>", "<assistant>"
SPECIAL_TOKENS = (PAD, EOS, TACTILE, USER, ASSISTANT, *SLOT_TOKENS)
"""In the order of their ids, which start at 0."""

_WORD_ROUNDS = 2000
"""Times each word of a slot stands in the corpus alone: often enough to become one token."""

VOCABULARY_SIZE = 1024
"""Holds the words of the templates whole; more would go to made-up nouns."""

_CONTROL = re.compile(
    rf"<\s*(/?(?:pad|eos|bos|tactile|user|assistant|system|{'|'.join(SLOTS)}))\s*>", re.IGNORECASE
)


def train_tokenizer(corpus: Iterable[str], vocabulary_size: int = VOCABULARY_SIZE) -> Tokenizer:
    """Return a tokenizer trained on `corpus`, special tokens first.

    Args:
        corpus: Questions and answers as they will be read and written.
        vocabulary_size: Upper bound; at least the 256 bytes and the special tokens.
    """
    words = SLOT_WORDS * _WORD_ROUNDS
    return byte_pairs(chain(corpus, words), vocabulary_size, special=SPECIAL_TOKENS)


def byte_pairs(texts: Iterable[str], size: int, special: Sequence[str] = ()) -> Tokenizer:
    """Return byte pairs made from texts; digits stay single, and every byte has a token.

    Args:
        texts: As they will be read.
        size: Upper bound of the vocabulary.
        special: Tokens that come first.
    """
    tokenizer = Tokenizer(models.BPE())
    tokenizer.pre_tokenizer = pre_tokenizers.Sequence(
        [
            pre_tokenizers.Digits(individual_digits=True),
            pre_tokenizers.ByteLevel(add_prefix_space=False),
        ]
    )
    tokenizer.decoder = decoders.ByteLevel()
    trainer = trainers.BpeTrainer(
        vocab_size=size,
        special_tokens=list(special),
        initial_alphabet=pre_tokenizers.ByteLevel.alphabet(),
        show_progress=False,
    )
    tokenizer.train_from_iterator(texts, trainer)
    return tokenizer


def clean_question(question: str) -> str:
    """Return the question as the model reads it: one line, lower case, no control tokens.

    Case carries no meaning in a question, and what somebody typed must never be read as a marker
    of the chat: "<tactile>" becomes "tactile", and so does "<<tactile>>".
    """
    text = " ".join(question.lower().split())
    while (plain := _CONTROL.sub(r"\1", text)) != text:
        text = plain
    return text
