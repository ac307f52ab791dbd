"""How large the language model is, and what of a sequence stands where."""

from __future__ import annotations

from dataclasses import dataclass

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
        layers: Decoder layers.
        heads: Attention heads.
        mlp: Width of the feed-forward layer.
        max_tokens: Longest sequence, prefix and slots among it.
    """

    width: int = 256
    layers: int = 6
    heads: int = 8
    mlp: int = 704
    max_tokens: int = 768
