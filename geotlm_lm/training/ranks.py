"""The processes that train one model together, as torchrun starts them; one alone is the same code.

Every rank draws the whole batch of a step from the step's seed, learns from its share and averages
gradients, so that batch, loss and weights are those of one process whatever the number of ranks,
and a checkpoint goes on on any number. Gradients are averaged by one all-reduce of a flat tensor,
not by `DistributedDataParallel`: a step here takes several backward passes through several of a
model's parts, which its hooks do not see, and for a few million weights overlap gains little.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta
from typing import TypeVar

import torch
import torch.distributed as dist
from torch import Tensor, nn

from geotlm_lm.core.errors import MissingDependency, UsageError, choice_of

Value = TypeVar("Value")

LONGEST_WAIT = timedelta(days=7)
"""For the first rank, which simulates alone for hours. Where one ends, torchrun ends the others."""

DEVICES = ("cpu", "cuda")


@dataclass(frozen=True)
class Ranks:
    """One of the processes that train together."""

    rank: int = 0  # which, from 0
    count: int = 1
    device: str = "cpu"  # where this one trains: cpu, cuda, or cuda with a number

    @property
    def is_first(self) -> bool:
        """Whether this is the one that simulates, writes and says how far it is."""
        return self.rank == 0

    @property
    def kind(self) -> str:
        """The device without its number, as autocast names it."""
        return self.device.partition(":")[0]

    def bfloat16_products(self, *, on_cpu: bool = True) -> torch.autocast:
        """Return the context in which products are in bfloat16 where the device is fast at them."""
        is_fast = has_bfloat16(self.kind) and (on_cpu or self.kind != "cpu")
        return torch.autocast(self.kind, torch.bfloat16, enabled=is_fast)

    def refuse_uneven(self, *batches: int) -> None:
        """Refuse batches that do not divide evenly among the ranks, by a UsageError."""
        for batch in batches:
            if batch % self.count:
                raise UsageError(
                    f"A batch of {batch} cannot be shared evenly by {self.count} processes; start "
                    f"a number that divides it."
                )

    def share(self, batch: Value) -> Value:
        """Return this rank's part of a sequence that is the same on every rank."""
        return batch[self.rank :: self.count]

    def asked_per_rank(self, is_asked: Tensor) -> Tensor:
        """Return how many are asked for on all ranks, at least one, over the number of ranks.

        A loss that divides by it averages over ranks to the mean of the whole batch.
        """
        asked = is_asked.sum()
        if self.count == 1:
            return asked.clamp(min=1)
        with _reporting_lost_ranks():
            dist.all_reduce(asked)
        return asked.clamp(min=1) / self.count

    def average(self, parameters: Iterable[nn.Parameter], loss: float) -> float:
        """Give every gradient its mean over the ranks, and return the loss's.

        A parameter that no rank has a gradient of keeps none.
        """
        if self.count == 1:
            return loss
        learned = [weight for weight in parameters if weight.requires_grad]
        has = [float(weight.grad is not None) for weight in learned]
        parts = [torch.zeros_like(w) if w.grad is None else w.grad for w in learned]
        head = torch.tensor([loss, *has], device=learned[0].device)
        flat = torch.cat([head, *(part.flatten() for part in parts)])
        with _reporting_lost_ranks():
            dist.all_reduce(flat)
        flat /= self.count
        head, *means = flat.split([len(head), *(part.numel() for part in parts)])
        for weight, mean, is_learned in zip(learned, means, head[1:].tolist(), strict=True):
            weight.grad = mean.view_as(weight) if is_learned else None
        return float(head[0])

    def from_first(self, make: Callable[[], Value]) -> Value:
        """Return what `make` returns on the first rank, where alone it is called; others wait."""
        if self.count == 1:
            return make()
        values = [make() if self.is_first else None]
        with _reporting_lost_ranks():
            dist.broadcast_object_list(values, src=0, device=torch.device("cpu"))
        return values[0]


ALONE = Ranks()
"""One process on the CPU."""


def is_first_of_launch() -> bool:
    """Tell whether this process is the first of those that torchrun started, or alone."""
    return int(os.environ.get("RANK", 0)) == 0


@contextmanager
def joined(device: str | None = None) -> Iterator[Ranks]:
    """Join the processes that torchrun started, by gloo on CPUs and nccl on GPUs.

    The device is as in `device_named`.
    """
    count, local = int(os.environ.get("WORLD_SIZE", 1)), int(os.environ.get("LOCAL_RANK", 0))
    place = device_named(device, local)
    if count == 1:
        yield Ranks(device=place)
        return
    if place != "cpu":
        torch.cuda.set_device(place)
    # What no tensor of a GPU holds, as words and rows, goes by gloo on GPUs too.
    backend = "gloo" if place == "cpu" else "cpu:gloo,cuda:nccl"
    dist.init_process_group(backend, timeout=LONGEST_WAIT)
    try:
        yield Ranks(dist.get_rank(), count, place)
    finally:
        dist.destroy_process_group()


def device_named(name: str | None, local: int = 0) -> str:
    """Return the torch device of this machine's process number `local`, from 0.

    Each has a GPU of its own; None is cuda where there is one.

    Raises:
        UsageError: If it is neither.
        MissingDependency: If there are too few GPUs.
    """
    gpus = torch.cuda.device_count() if torch.cuda.is_available() else 0
    if name is None:
        name = "cuda" if gpus else "cpu"
    if name not in DEVICES:
        raise UsageError(f"There is no device '{name}'; {choice_of(name, DEVICES)}")
    if name == "cpu":
        return name
    if local >= gpus:
        raise MissingDependency(
            f"{gpus} GPUs were found by torch, expected at least {local + 1}; start fewer "
            f"processes, or choose --device cpu."
        )
    return f"cuda:{local}" if "LOCAL_RANK" in os.environ else "cuda"


def has_bfloat16(kind: str) -> bool:
    """Tell whether bfloat16 products are fast.

    2.7 times float32 on a processor with tiles (AMX), half as fast as that with AVX-512's alone.
    """
    if kind == "cuda":
        return torch.cuda.is_bf16_supported(including_emulation=False)
    return torch.cpu._is_amx_tile_supported()


@contextmanager
def _reporting_lost_ranks() -> Iterator[None]:
    """Say in one sentence that another rank has ended: gloo's and nccl's own are long."""
    try:
        yield
    except RuntimeError as error:
        raise UsageError(
            "Another process of this training has ended; start all again, and they go on from the "
            "last checkpoint."
        ) from error
