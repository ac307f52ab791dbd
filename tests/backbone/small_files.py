"""Files in the released containers, of small random encoders, for tests without any real file."""

import argparse

import torch
from safetensors.torch import save_file

from tests.backbone.full_size import FILES

SMALL_WIDTH = 24


def small(name):
    """Return the tensors of a released file with the widths shrunk and two blocks left."""
    generator = torch.Generator().manual_seed(0)
    found = {}
    for own, value in FILES[name]().items():
        if any(f"{part}.{n}." in own for part in ("layers", "blocks") for n in range(2, 30)):
            continue
        if own == "pos_embed.frequency_bands":
            found[own] = (10000.0 ** -(torch.arange(4) / 4)).expand(3, -1).clone()
            continue
        sizes = [_small(name, size) for size in _fewer_patches(name, own, list(value.shape))]
        draw = torch.randn(sizes, generator=generator) / max(1, value[0].numel()) ** 0.5
        found[own] = draw + 1 if "norm" in own and own.endswith("weight") else draw
    return found


def _small(name, size):
    if name == "unit":
        return {128: 32, 256: 64, 512: 32}.get(size, size)
    width = 1024 if name in ("internvit", "anytouch1") else 768
    wide = {width: SMALL_WIDTH, 3 * width: 3 * SMALL_WIDTH, 4 * width: 4 * SMALL_WIDTH}
    projected = {512: 20} if name == "anytouch2" else {768: 20}
    return wide.get(size, projected.get(size, size))


def _fewer_patches(name, own, sizes):
    """Shrink the grid of learned positions to 3 x 3, of AnyTouch 2 in both time-bins."""
    if "position" not in own and "pos_embed" not in own:
        return sizes
    axis = 0 if own.endswith("position_embedding.weight") else 1
    sizes[axis] = 1 + 9 * (2 if name == "anytouch2" else 1)
    return sizes


def write_small(name, folder, change=None):
    """Write a small encoder as its authors would, after `change` to its tensors; return the file.

    Names are those of the file: with its prefix, without the level above it.
    """
    folder.mkdir(exist_ok=True)
    tensors = small(name)
    if name == "t3":
        return _write_t3(folder, tensors, change)
    if name == "anytouch1":
        at = "touch_mae_model.touch_model.embeddings.patch_embedding.weight"
        tensors[at] = torch.ones(SMALL_WIDTH, 3, 14, 14)
        tensors["touch_mae_model.decoder_embed.weight"] = torch.ones(2, 2)
    if change is not None:
        change(tensors)
    if name in ("sparsh", "internvit"):
        path = folder / "model.safetensors"
        save_file({own: value.contiguous() for own, value in tensors.items()}, path)
        return path
    stored = {
        "anytouch2": tensors,
        "anytouch1": {"model": tensors, "args": argparse.Namespace(rate=1), "epoch": 3},
        "unit": {"state_dict": tensors | {"decoder.conv_in.bias": torch.ones(2)}, "epoch": 3},
    }[name]
    torch.save(stored, folder / "checkpoint.pth")
    return folder / "checkpoint.pth"


def _write_t3(folder, tensors, change):
    parts = {}
    for part in ("encoder", "trunk"):
        prefix = f"{part}."
        parts[part] = {
            own[len(prefix) :]: v for own, v in tensors.items() if own.startswith(prefix)
        }
    if change is not None:
        change(parts["encoder"])
    (folder / "encoders").mkdir(exist_ok=True)
    torch.save(parts["encoder"], folder / "encoders" / "mini.pth")
    torch.save(parts["trunk"], folder / "trunk.pth")
    return folder / "encoders" / "mini.pth"
