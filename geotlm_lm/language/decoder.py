"""A small Llama-style decoder in plain torch, key by key the one transformers builds.

`language.model` is the same network as a transformers class and reads the same weights; this file
exists because importing that class takes longer than a cold answer may. A test pins that both give
the same logits. It is what is trained; `sequence` takes one text at a time through its weights. It
knows ids and embeddings, not text.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn.functional import linear, scaled_dot_product_attention, silu

from geotlm_lm.language.projector import Projector

ROPE_THETA = 10_000.0
"""Base of the rotary frequencies, transformers' default for Llama."""

RMS_EPSILON = 1e-6

EMBEDDING_DEVIATION = 0.04
"""Of fresh embeddings, which serve as output weights too: wider only starts at a higher loss."""


UNSEEN = -1e4
"""Score of what may not be seen; finite, so that a row that sees nothing stays a number."""


@dataclass(frozen=True)
class LanguageSize:
    """How large the language model is.

    Args:
        width: Width of the embeddings.
        layers: Decoder layers.
        heads: Attention heads.
        mlp: Width of the feed-forward layer.
        tactile_tokens: Prefix embeddings per clip.
        max_tokens: Longest prompt and answer together.
    """

    width: int = 128
    layers: int = 4
    heads: int = 4
    mlp: int = 344
    tactile_tokens: int = 3
    max_tokens: int = 120


class RMSNorm(nn.Module):
    """Scale to unit root mean square."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.ones(width))

    def forward(self, x: Tensor) -> Tensor:
        """Return `x` normalised over its last axis."""
        return torch.rms_norm(x, self.weight.shape, self.weight, RMS_EPSILON)


class Attention(nn.Module):
    """Causal self-attention with rotary positions."""

    def __init__(self, size: LanguageSize) -> None:
        super().__init__()
        self.heads = size.heads
        for name in ("q_proj", "k_proj", "v_proj", "o_proj"):
            self.add_module(name, nn.Linear(size.width, size.width, bias=False))

    def forward(self, x: Tensor, turn: tuple[Tensor, Tensor], mask: Tensor | None) -> Tensor:
        """Return the mixed values."""
        shape = (*x.shape[:2], self.heads, -1)
        query, key, value = (
            project(x).view(shape).transpose(1, 2)
            for project in (self.q_proj, self.k_proj, self.v_proj)
        )
        query, key = rotate(query, *turn), rotate(key, *turn)
        mixed = _attended(query, key, value, mask)
        return self.o_proj(mixed.transpose(1, 2).flatten(2))


def _attended(query: Tensor, key: Tensor, value: Tensor, mask: Tensor | None) -> Tensor:
    """Return the values mixed by what each position may see.

    On processors torch's kernel for masked attention takes twice as long as these four products.
    """
    if mask is None or query.is_cuda:
        return scaled_dot_product_attention(
            query, key, value, attn_mask=mask, is_causal=mask is None
        )
    scores = (query * query.shape[-1] ** -0.5) @ key.mT
    return scores.masked_fill(~mask, UNSEEN).softmax(-1).to(value.dtype) @ value


class FeedForward(nn.Module):
    """Gated feed-forward layer."""

    def __init__(self, size: LanguageSize) -> None:
        super().__init__()
        self.gate_proj = nn.Linear(size.width, size.mlp, bias=False)
        self.up_proj = nn.Linear(size.width, size.mlp, bias=False)
        self.down_proj = nn.Linear(size.mlp, size.width, bias=False)

    def forward(self, x: Tensor) -> Tensor:
        """Return the layer's output."""
        return self.down_proj(silu(self.gate_proj(x)) * self.up_proj(x))


class DecoderLayer(nn.Module):
    """Attention and feed-forward, each normalised before and added after."""

    def __init__(self, size: LanguageSize) -> None:
        super().__init__()
        self.self_attn = Attention(size)
        self.mlp = FeedForward(size)
        self.input_layernorm = RMSNorm(size.width)
        self.post_attention_layernorm = RMSNorm(size.width)

    def forward(self, x: Tensor, turn: tuple[Tensor, Tensor], mask: Tensor | None) -> Tensor:
        """Return the layer's output."""
        x = x + self.self_attn(self.input_layernorm(x), turn, mask)
        return x + self.mlp(self.post_attention_layernorm(x))


class LlamaDecoder(nn.Module):
    """Embeddings -> hidden states, with the parameter names of transformers' LlamaModel."""

    def __init__(self, size: LanguageSize, vocabulary: int) -> None:
        super().__init__()
        self.embed_tokens = nn.Embedding(vocabulary, size.width)
        self.layers = nn.ModuleList(DecoderLayer(size) for _ in range(size.layers))
        self.norm = RMSNorm(size.width)
        half = torch.arange(0, size.width // size.heads, 2).float() / (size.width // size.heads)
        angles = torch.arange(size.max_tokens).float()[:, None] * ROPE_THETA**-half
        angles = torch.cat([angles, angles], dim=-1)
        self.register_buffer("cos", angles.cos(), persistent=False)
        self.register_buffer("sin", angles.sin(), persistent=False)

    def forward(self, x: Tensor, mask: Tensor | None = None) -> Tensor:
        """Return hidden states (b, s, width).

        Args:
            x: Embeddings of right-padded texts, (b, s, width).
            mask: True where a position may look, (b, 1, s, s); None for plain causal order.
        """
        turn = self.cos[: x.shape[1]], self.sin[: x.shape[1]]
        for layer in self.layers:
            x = layer(x, turn, mask)
        return self.norm(x)


class TactileDecoder(nn.Module):
    """The projector and the decoder: ids and a fused token -> hidden states -> logits.

    Args:
        size: How large.
        fused_width: Width of the fused token.
        vocabulary: Tokens in the vocabulary.
        tactile_id: Id of the placeholder that the prefix embeddings replace.
    """

    def __init__(
        self, size: LanguageSize, *, fused_width: int, vocabulary: int, tactile_id: int
    ) -> None:
        super().__init__()
        self.size, self.fused_width = size, fused_width
        self.vocabulary, self.tactile_id = vocabulary, tactile_id
        self.model = nn.Module()
        self.model.projector = Projector(fused_width, size.width, size.tactile_tokens)
        self.model.language_model = LlamaDecoder(size, vocabulary)

    @property
    def projector(self) -> Projector:
        """The part that reads the fused token."""
        return self.model.projector

    @property
    def decoder(self) -> LlamaDecoder:
        """The part that reads and writes text."""
        return self.model.language_model

    def embed(self, ids: Tensor, prefix: Tensor | None) -> Tensor:
        """Return embeddings of `ids` (b, s), the placeholders replaced by `prefix` (b, k, width).

        Raises:
            ValueError: If a row does not hold exactly k placeholders.
        """
        embedded = self.decoder.embed_tokens(ids)
        return embedded if prefix is None else merge_prefix(embedded, ids, prefix, self.tactile_id)

    def logits(self, hidden: Tensor) -> Tensor:
        """Return the logits over the vocabulary; the output weights are the embeddings."""
        return linear(hidden, self.decoder.embed_tokens.weight)

    def slot_logits(
        self, prefix: Tensor, prompt: list[int], words: dict[str, list[int]]
    ) -> dict[str, Tensor]:
        """Return the log-probabilities of the words that may fill each slot, (b, words) each.

        Args:
            prefix: (b, k, width).
            prompt: Ids of k placeholders and of the slots, in the order of `words`.
            words: Slot -> ids of its words.
        """
        ids = torch.tensor(prompt, device=prefix.device).expand(len(prefix), -1)
        hidden = self.decoder(self.embed(ids, prefix))
        logits = self.logits(hidden[:, -len(words) :])
        return {
            slot: logits[:, place, among].log_softmax(dim=-1)
            for place, (slot, among) in enumerate(words.items())
        }


@torch.no_grad()
def initialise(model: nn.Module, layers: int, generator: torch.Generator) -> None:
    """Draw every weight: normal, of unit gain, narrower where a layer adds to the stream.

    Measured at width 128: with unit gain the verify questions leave chance after 500 steps of 64;
    with the usual 0.02 everywhere they had not after 1000.

    Args:
        model: Holds a `LlamaDecoder`.
        layers: How many that has.
        generator: Draws.
    """
    shrink = (2 * layers) ** -0.5
    for name, parameter in model.named_parameters():
        if parameter.ndim < 2:
            parameter.fill_(1.0 if "norm" in name else 0.0)
        elif "embed_tokens" in name:
            parameter.normal_(0.0, EMBEDDING_DEVIATION, generator=generator)
        else:
            adds = name.endswith(("o_proj.weight", "down_proj.weight"))
            gain = parameter.shape[1] ** -0.5 * (shrink if adds else 1.0)
            parameter.normal_(0.0, gain, generator=generator)


def merge_prefix(embedded: Tensor, ids: Tensor, prefix: Tensor, tactile_id: int) -> Tensor:
    """Return `embedded` with its placeholders replaced, row by row, by `prefix`.

    Raises:
        ValueError: If a row does not hold exactly as many placeholders as the prefix is long.
    """
    is_placeholder = ids == tactile_id
    counts = is_placeholder.sum(dim=1)
    if len(prefix) != len(ids) or bool((counts != prefix.shape[1]).any()):
        raise ValueError(
            f"prompts hold {counts.tolist()} tactile placeholders, but the clips give "
            f"{tuple(prefix.shape[:2])} prefix embeddings; build prompts with the model's processor"
        )
    return embedded.masked_scatter(is_placeholder[..., None], prefix.to(embedded.dtype))


def rotate(x: Tensor, cos: Tensor, sin: Tensor) -> Tensor:
    """Turn each head by its position's angles, first half against second half."""
    first, second = x.chunk(2, dim=-1)
    return x * cos + torch.cat([-second, first], dim=-1) * sin
