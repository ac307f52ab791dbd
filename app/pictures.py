"""Pictures that the browser fetches by address: the frames of a recording in one pack, in memory.

A value of the page is copied several times on its way; frames in it held the browser up for
seconds. The key of a pack is made of what the frames are: the same recording is encoded once.
"""

from __future__ import annotations

import base64
import hashlib
import secrets
import struct
from collections import OrderedDict
from threading import Lock
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from starlette.responses import Response

from .guards import MIB

Image = NDArray[np.uint8]

ROUTE = "frames"
"""Where packs are served, below the page's address."""

BUDGET_BYTES = 2_800_000
"""Of all pictures of a recording together."""

QUALITIES = ((448, 88), (448, 75), (320, 75), (320, 60), (224, 60), (224, 40), (160, 40))
"""Longer side (pixels) and JPEG quality, the best first; the first that fits is used."""

SAMPLED = 6
"""Frames that are tried to see how many bytes a quality takes."""

KEPT_BYTES = 128 * MIB
"""Of all packs; the browser has fetched what is let go of, or asks for it once more and is told."""


class Packs:
    """Packs by their keys; those that were asked for longest ago go first."""

    def __init__(self) -> None:
        self._kept: OrderedDict[str, bytes] = OrderedDict()
        self._secret, self._lock = secrets.token_bytes(16), Lock()

    def address(self, images: list[Image]) -> str:
        """Return where the pictures can be fetched, each as good as the budget allows."""
        digest = hashlib.blake2b(key=self._secret, digest_size=16)
        for image in images:
            digest.update(repr(image.shape).encode())
            digest.update(np.ascontiguousarray(image))
        key = digest.hexdigest()
        if self.content(key) is None:
            pack = _packed(images)
            with self._lock:
                self._kept[key] = pack
                while sum(map(len, self._kept.values())) > KEPT_BYTES and len(self._kept) > 1:
                    self._kept.popitem(last=False)
        return f"{ROUTE}/{key}"

    def content(self, key: str) -> bytes | None:
        """Return a pack: how many pictures, the length of each, the files; None without it."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
            return self._kept.get(key)


PACKS = Packs()
"""Of this process."""


async def serve_pack(request: Any) -> Any:
    """Answer a request for a pack; nobody can guess a key."""
    content = PACKS.content(request.path_params["key"])
    if content is None:
        return Response("These pictures are gone; open the recording again.", 404)
    headers = {"cache-control": "private, max-age=3600, immutable"}
    return Response(content, media_type="application/octet-stream", headers=headers)


def _packed(images: list[Image]) -> bytes:
    places = np.linspace(0, len(images) - 1, SAMPLED).round().astype(int)
    for side, quality in QUALITIES:
        size = sum(len(jpeg(images[place], side, quality)) for place in places) / len(places)
        if size * len(images) <= BUDGET_BYTES:
            break
    files = [jpeg(image, side, quality) for image in images]
    return b"".join([struct.pack(f"<{len(files) + 1}I", len(files), *map(len, files)), *files])


def jpeg(image: Image, side: int, quality: int) -> bytes:
    """Return a picture as a file, made smaller where its longer side is beyond `side`."""
    scale = side / max(image.shape[:2])
    if scale < 1:
        size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    return cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), options)[1].tobytes()


def jpeg_address(image: Image, side: int, quality: int) -> str:
    """Return a picture as a data address."""
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg(image, side, quality)).decode()}"
