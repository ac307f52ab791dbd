"""Released files: names and shapes written down from the authors' code, and small ones on disk.

Small files have random weights and the released containers, for tests without any real file.
"""

import argparse

import torch
from safetensors.torch import save_file


def shaped(sizes):
    return {name: torch.empty(*size, device="meta") for name, size in sizes.items()}


def layer(name, before, after):
    return {f"{name}.weight": (after, before), f"{name}.bias": (after,)}


def norm(name, width):
    return {f"{name}.weight": (width,), f"{name}.bias": (width,)}


def clip_layers(prefix, depth, d):
    sizes = {}
    for i in range(depth):
        at = f"{prefix}{i}."
        for part in ("q_proj", "k_proj", "v_proj", "out_proj"):
            sizes |= layer(f"{at}self_attn.{part}", d, d)
        sizes |= norm(f"{at}layer_norm1", d) | norm(f"{at}layer_norm2", d)
        sizes |= layer(f"{at}mlp.fc1", d, 4 * d) | layer(f"{at}mlp.fc2", 4 * d, d)
    return sizes


def timm_layers(prefix, depth, d, gain=""):
    sizes = {}
    for i in range(depth):
        at = f"{prefix}{i}."
        sizes |= norm(f"{at}norm1", d) | norm(f"{at}norm2", d)
        sizes |= layer(f"{at}attn.qkv", d, 3 * d) | layer(f"{at}attn.proj", d, d)
        sizes |= layer(f"{at}mlp.fc1", d, 4 * d) | layer(f"{at}mlp.fc2", 4 * d, d)
        sizes |= {f"{at}ls{n}{gain}": (d,) for n in (1, 2)} if gain is not None else {}
    return sizes


def anytouch2():
    at = "touch_mae_model.touch_model."
    sizes = {
        "touch_mae_model.sensor_token": (20, 5, 768),
        "touch_mae_model.new_position_ids": (1, 393),
        f"{at}embeddings.class_embedding": (768,),
        f"{at}embeddings.patch_embedding.weight": (768, 3, 2, 16, 16),
        f"{at}embeddings.position_embedding.weight": (393, 768),
        "touch_mae_model.touch_projection.weight": (512, 768),
    }
    sizes |= norm(f"{at}pre_layrnorm", 768) | norm(f"{at}post_layernorm", 768)
    return shaped(sizes | clip_layers(f"{at}encoder.layers.", 12, 768))


def anytouch1():
    at = "touch_mae_model.touch_model."
    sizes = {
        "touch_mae_model.sensor_token": (10, 5, 1024),
        f"{at}embeddings.class_embedding": (1024,),
        f"{at}embeddings.position_embedding.weight": (257, 1024),
        "touch_mae_model.video_patch_embedding.weight": (1024, 3, 3, 14, 14),
        "touch_mae_model.touch_projection.weight": (768, 1024),
    }
    sizes |= norm(f"{at}pre_layrnorm", 1024) | norm(f"{at}post_layernorm", 1024)
    return shaped(sizes | clip_layers(f"{at}encoder.layers.", 24, 1024))


def sparsh():
    sizes = {
        "register_tokens": (1, 1, 768),
        "patch_embed.proj.weight": (768, 3, 2, 16, 16),
        "patch_embed.proj.bias": (768,),
    }
    tensors = shaped(sizes | norm("norm", 768) | timm_layers("blocks.", 12, 768, ".gamma"))
    frequencies = 10000.0 ** -(torch.arange(128) / 128)
    return tensors | {"pos_embed.frequency_bands": frequencies.expand(3, -1)}


def internvit():
    sizes = {
        "embeddings.class_embedding": (1, 1, 1024),
        "embeddings.position_embedding": (1, 1025, 1024),
        "embeddings.patch_embedding.weight": (1024, 3, 14, 14),
        "embeddings.patch_embedding.bias": (1024,),
    }
    return shaped(sizes | timm_layers("encoder.layers.", 24, 1024, ""))


def t3():
    sizes = {
        "encoder.cls_token": (1, 1, 768),
        "encoder.pos_embed": (1, 197, 768),
        "encoder.patch_embed.proj.weight": (768, 3, 16, 16),
        "encoder.patch_embed.proj.bias": (768,),
    }
    sizes |= timm_layers("encoder.blocks.", 3, 768, None)
    return shaped(sizes | timm_layers("trunk.blocks.", 9, 768, None) | norm("trunk.norm", 768))


def conv(name, before, after, side):
    return {f"{name}.weight": (after, before, side, side), f"{name}.bias": (after,)}


def residual(name, before, after):
    sizes = norm(f"{name}.norm1", before) | conv(f"{name}.conv1", before, after, 3)
    sizes |= norm(f"{name}.norm2", after) | conv(f"{name}.conv2", after, after, 3)
    return sizes | (conv(f"{name}.nin_shortcut", before, after, 1) if before != after else {})


def attention(name, d):
    sizes = norm(f"{name}.norm", d)
    for part in ("q", "k", "v", "proj_out"):
        sizes |= conv(f"{name}.{part}", d, d, 1)
    return sizes


def unit():
    widths = (128, 128, 256, 512)
    sizes = conv("encoder.conv_in", 3, 128, 3)
    for level, (before, after) in enumerate(zip((128, *widths), widths, strict=False)):
        at = f"encoder.down.{level}"
        sizes |= residual(f"{at}.block.0", before, after) | residual(f"{at}.block.1", after, after)
        if level < 3:
            sizes |= conv(f"{at}.downsample.conv", after, after, 3)
        else:
            sizes |= attention(f"{at}.attn.0", after) | attention(f"{at}.attn.1", after)
    sizes |= residual("encoder.mid.block_1", 512, 512) | residual("encoder.mid.block_2", 512, 512)
    sizes |= attention("encoder.mid.attn_1", 512) | norm("encoder.norm_out", 512)
    sizes |= conv("encoder.conv_out", 512, 3, 3) | conv("quant_conv", 3, 3, 1)
    return shaped(sizes)


FILES = {f.__name__: f for f in (anytouch2, anytouch1, sparsh, t3, internvit, unit)}

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
