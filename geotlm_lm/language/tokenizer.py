"""Byte pairs made from texts; knows text only.

Digits stay single, so that numbers are spelled and never guessed whole; every byte has a token, so
that no question is unreadable.
"""

from __future__ import annotations

from collections.abc import Iterable

from tokenizers import Tokenizer, decoders, models, pre_tokenizers, trainers


def byte_pairs(texts: Iterable[str], size: int) -> Tokenizer:
    """Return byte pairs made from texts; digits stay single, and every byte has a token.

    Args:
        texts: As they will be read.
        size: Upper bound of the vocabulary.
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
        initial_alphabet=pre_tokenizers.ByteLevel.alphabet(),
        show_progress=False,
    )
    tokenizer.train_from_iterator(texts, trainer)
    return tokenizer
