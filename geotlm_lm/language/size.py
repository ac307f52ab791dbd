"""How large the language model is, and what of a sequence stands where."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

PREFIX = 4
"""Embeddings of a clip that stand before everything else: two of its fused token, two of belief."""

SLOTS: dict[str, tuple[str, ...]] = {
    "turn": ("cw", "ccw", "none"),
    "slide": ("left", "right", "up", "down", "none"),
    "press": ("in", "out", "none"),
    "contact": ("touch", "none"),
}
"""Slot -> the words of programs that may fill it; the words at a slot exclude each other."""

TEXT = PREFIX + len(SLOTS)
"""Position of a question's first token, whether or not a clip stands before it."""

ROPE_THETA, RMS_EPSILON = 10_000.0, 1e-6


@dataclass(frozen=True)
class LanguageSize:
    """How large a language model is.

    Args:
        width: Width of the embeddings.
        layers: Decoder layers that read questions and clips.
        heads: Attention heads.
        mlp: Width of the feed-forward layer.
        max_tokens: Longest sequence, prefix and slots among it.
        speaking: Layers above those that read, of which sentences alone are read out.
    """

    width: int = 256
    layers: int = 6
    heads: int = 8
    mlp: int = 704
    max_tokens: int = 768
    speaking: int = 2


def size_of(config: Mapping[str, Any]) -> LanguageSize:
    """Return how large the model of a transformers' configuration is.

    Raises:
        KeyError, ValueError: If it is none of this package's.
    """
    size = LanguageSize(
        width=config["hidden_size"],
        layers=config["reading_layers"],
        heads=config["num_attention_heads"],
        mlp=config["intermediate_size"],
        max_tokens=config["max_position_embeddings"],
        speaking=config["num_hidden_layers"] - config["reading_layers"],
    )
    if min(size.layers, size.speaking) < 0:
        raise ValueError(f"{size.layers} layers read and {size.speaking} speak")
    if size.heads < 1 or size.width % (2 * size.heads):
        raise ValueError(f"a width of {size.width} makes no {size.heads} heads of even width")
    return size
