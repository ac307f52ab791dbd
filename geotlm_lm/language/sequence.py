"""Run one text at a time through the language model in NumPy.

For a single text through a decoder this small, torch spends more on dispatch than on arithmetic,
and transformers takes longer to import than a cold answer may. A test pins that both give the same
hidden states, whatever may be seen.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from safetensors.numpy import load_file, save

from geotlm_lm.core.files import replacing, write_text_atomically
from geotlm_lm.language.size import (
    PREFIX,
    RMS_EPSILON,
    ROPE_THETA,
    SLOTS,
    TEXT,
    LanguageSize,
    size_of,
)

Floats = NDArray[np.float32]

CONFIG_FILE, WEIGHTS_FILE = "config.json", "model.safetensors"
PROJECTOR_FILE = "projector.safetensors"


class _Layer(NamedTuple):
    """Weights of a layer as (in, out), each norm's gain in the products behind it."""

    attend: Floats  # width -> queries (scaled), keys and values
    mix: Floats
    widen: Floats  # width -> gate and up
    narrow: Floats


class TextCache:
    """Keys and values of a sequence so far.

    Args:
        layers: Layers of the decoder.
        heads: Its heads.
        head_width: Their width.
        room: Longest sequence.
        position: Of its first embedding.
    """

    def __init__(self, layers: int, heads: int, head_width: int, room: int, position: int) -> None:
        self.keys = np.empty((layers, heads, room, head_width), np.float32)
        self.values = np.empty_like(self.keys)
        self.length, self.position = 0, position

    def copied(self, room: int) -> TextCache:
        """Return the same sequence with room for more behind it."""
        layers, heads, _, width = self.keys.shape
        other = TextCache(layers, heads, width, self.length + room, self.position)
        other.keys[:, :, : self.length] = self.keys[:, :, : self.length]
        other.values[:, :, : self.length] = self.values[:, :, : self.length]
        other.length = self.length
        return other


class SequenceDecoder:
    """A decoder's weights, for one text at a time and without gradients.

    Args:
        config: transformers' configuration of it, as plain values.
        weights: By transformers' names, in any precision.
        projector: Weights of the tactile projector, by name.

    Raises:
        KeyError, ValueError: If they do not fit together.
    """

    def __init__(
        self,
        config: Mapping[str, Any],
        weights: Mapping[str, NDArray],
        projector: Mapping[str, NDArray],
    ) -> None:
        self.config, self.stored, self._projector = dict(config), dict(weights), dict(projector)
        self.size = size = size_of(config)
        self.projector = {name: _wide(x) for name, x in projector.items()}
        self.embeddings = _wide(weights["model.embed_tokens.weight"])
        self._gain = _wide(weights["model.norm.weight"])
        count = size.layers + size.speaking
        self._layers = [_layer(weights, f"model.layers.{k}.", size) for k in range(count)]
        half = np.arange(0, size.width // size.heads, 2) / (size.width // size.heads)
        angles = np.arange(size.max_tokens)[:, None] * ROPE_THETA**-half
        angles = np.concatenate([angles, angles], axis=-1)[:, None]
        self._cos, self._sin = (f(angles).astype(np.float32) for f in (np.cos, np.sin))

    @classmethod
    def load(cls, folder: Path) -> SequenceDecoder:
        """Read a folder as transformers writes it, and the projector beside it.

        Raises:
            OSError, ValueError, KeyError, SafetensorError: If files are missing or do not fit.
        """
        config = json.loads((folder / CONFIG_FILE).read_text(encoding="utf-8"))
        return cls(config, load_file(folder / WEIGHTS_FILE), load_file(folder / PROJECTOR_FILE))

    def save(self, folder: Path) -> None:
        """Write the same files, each atomically."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, tensors in ((WEIGHTS_FILE, self.stored), (PROJECTOR_FILE, self._projector)):
            half = {key: np.asarray(x, np.float16) for key, x in tensors.items()}
            with replacing(folder / name) as stream:
                stream.write(save(half, metadata={"format": "pt"}))
        write_text_atomically(folder / CONFIG_FILE, json.dumps(self.config, indent=2) + "\n")

    @property
    def vocabulary(self) -> int:
        """How many ids there are."""
        return len(self.embeddings)

    @property
    def clip_width(self) -> int:
        """Numbers that are read of a clip."""
        return len(self.projector["mean"])

    def started(self, room: int, position: int = TEXT) -> TextCache:
        """Return an empty sequence with room for so many embeddings."""
        width = self.size.width // self.size.heads
        return TextCache(len(self._layers), self.size.heads, width, room, position)

    def read(self, x: Floats, cache: TextCache, sight: NDArray[np.bool_] | None = None) -> Floats:
        """Return the states (s, width) that programs are read from, of embeddings (s, width).

        Args:
            x: Embeddings of the tokens that follow.
            cache: The sequence; grows by them.
            sight: What each of them sees of all there are then, (s, length); None for all up to
                itself.
        """
        return self._through(x, cache, sight)[0]

    def speak(self, x: Floats, cache: TextCache, sight: NDArray[np.bool_] | None = None) -> Floats:
        """Return the states that sentences are read from, as `read` does."""
        return self._through(x, cache, sight, is_spoken=True)[1]

    def _through(
        self,
        x: Floats,
        cache: TextCache,
        sight: NDArray[np.bool_] | None,
        is_spoken: bool = False,
    ) -> tuple[Floats, Floats]:
        """Return the states behind the layers that read, and behind those that speak."""
        before, count = cache.length, len(x)
        cache.length = before + count
        hidden = None
        if sight is None and count > 1:
            sight = np.tri(count, before + count, before, dtype=bool)
        if sight is not None and not sight.all():
            hidden = ~sight
        read = x
        for place, layer in enumerate(self._layers[: None if is_spoken else self.size.layers]):
            x = x + self._attended(_normed(x), layer, place, before, cache, hidden)
            wide = _normed(x) @ layer.widen
            gate, up = wide[:, : wide.shape[1] // 2], wide[:, wide.shape[1] // 2 :]
            x = x + (_silu(gate) * up) @ layer.narrow
            read = x if place < self.size.layers else read
        return _normed(read) * self._gain, _normed(x) * self._gain

    def logits(self, hidden: Floats) -> Floats:
        """Return the logits over the vocabulary; the output weights are the embeddings."""
        return hidden @ self.embeddings.T

    def prefixed(self, numbers: Floats, slot_ids: Sequence[int]) -> tuple[TextCache, Floats]:
        """Return a clip's prefix and slots as a sequence, and the slots' logits (slots, ids).

        Args:
            numbers: What is read of the clip, (clip width,).
            slot_ids: Ids of the slots, in the order of `size.SLOTS`.
        """
        embedded = np.concatenate([self._prefix(numbers), self.embeddings[list(slot_ids)]])
        cache = self.started(len(embedded), position=0)
        states, _ = self._through(embedded, cache, sight_of_clip(), is_spoken=True)
        return cache, self.logits(states[PREFIX:])

    def _prefix(self, numbers: Floats) -> Floats:
        weights = self.projector
        plain = (numbers - weights["mean"]) / weights["scale"]
        halves, at = [], 0
        for k in (0, 1):
            expand = weights[f"expand.{k}.weight"]
            part = plain[at : at + expand.shape[1]]
            wide = _silu(expand @ part + weights[f"expand.{k}.bias"])
            halves.append(weights[f"project.{k}.weight"] @ wide + weights[f"project.{k}.bias"])
            at += expand.shape[1]
        return np.concatenate(halves).reshape(PREFIX, -1)

    def _attended(
        self,
        x: Floats,
        layer: _Layer,
        place: int,
        before: int,
        cache: TextCache,
        hidden: NDArray[np.bool_] | None,
    ) -> Floats:
        count, width, end, heads = *x.shape, cache.length, self.size.heads
        first, last = cache.position + before, cache.position + end
        mixed = (x @ layer.attend).reshape(count, 3 * heads, -1)
        turned = _rotated(mixed[:, : 2 * heads], self._cos[first:last], self._sin[first:last])
        turned = turned.transpose(1, 0, 2)
        keys, values = cache.keys[place], cache.values[place]
        keys[:, before:end] = turned[heads:]
        values[:, before:end] = mixed[:, 2 * heads :].transpose(1, 0, 2)
        scores = turned[:heads] @ keys[:, :end].transpose(0, 2, 1)
        if hidden is not None:
            scores[:, hidden] = -np.inf
        scores -= scores.max(axis=-1, keepdims=True)
        np.exp(scores, out=scores)
        scores /= scores.sum(axis=-1, keepdims=True)
        seen = (scores @ values[:, :end]).transpose(1, 0, 2).reshape(count, width)
        return seen @ layer.mix


def sight_of_clip() -> NDArray[np.bool_]:
    """Return which of prefix and slots each sees: the prefix itself, a slot itself as well."""
    count = PREFIX + len(SLOTS)
    sight = np.eye(count, dtype=bool)
    sight[:, :PREFIX] = True
    return sight


def log_softmax(logits: Floats) -> Floats:
    """Return log-probabilities over the last axis."""
    above = logits - logits.max(axis=-1, keepdims=True)
    return above - np.log(np.exp(above).sum(axis=-1, keepdims=True))


def _layer(weights: Mapping[str, NDArray], name: str, size: LanguageSize) -> _Layer:
    def part(of: str) -> Floats:
        return _wide(weights[f"{name}{of}.weight"])

    first, second = part("input_layernorm")[:, None], part("post_attention_layernorm")[:, None]
    query, key, value = (part(f"self_attn.{of}_proj").T * first for of in "qkv")
    scale = np.float32((size.width // size.heads) ** -0.5)
    widen = [part(f"mlp.{of}_proj").T * second for of in ("gate", "up")]
    return _Layer(
        np.concatenate([query * scale, key, value], axis=1),
        np.ascontiguousarray(part("self_attn.o_proj").T),
        np.concatenate(widen, axis=1),
        np.ascontiguousarray(part("mlp.down_proj").T),
    )


def _wide(x: NDArray) -> Floats:
    return np.asarray(x, np.float32)


def _silu(x: Floats) -> Floats:
    return x * (0.5 + 0.5 * np.tanh(0.5 * x))


def _normed(x: Floats) -> Floats:
    square = np.einsum("ij,ij->i", x, x)[:, None] / np.float32(x.shape[1])
    return x / np.sqrt(square + np.float32(RMS_EPSILON))


def _rotated(x: Floats, cos: Floats, sin: Floats) -> Floats:
    """Turn each head by its position's angles, first half against second half."""
    half = x.shape[-1] // 2
    turned = x * cos
    turned[..., :half] -= x[..., half:] * sin[..., :half]
    turned[..., half:] += x[..., :half] * sin[..., half:]
    return turned
