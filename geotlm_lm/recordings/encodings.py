"""Encodings of uncompressed images in bags: how a pixel is held, and how it becomes RGB."""

from __future__ import annotations

from dataclasses import dataclass

import cv2


@dataclass(frozen=True)
class Encoding:
    """How an image message holds a pixel.

    Args:
        channels: Values of one, as they are stored.
        to_rgb: OpenCV's conversion of them to RGB; None where they are RGB.
        bits: Of a value, 8 or 16.
    """

    channels: int
    to_rgb: int | None
    bits: int = 8


def _in_8_and_16_bits(name: str, channels: int, to_rgb: int | None) -> dict[str, Encoding]:
    return {f"{name}{bits}": Encoding(channels, to_rgb, bits) for bits in (8, 16)}


# Named by the four pixels at the upper left, as ROS does, and not by OpenCV's older names, which
# begin at the second row and column.
_MOSAICS = {
    "rggb": cv2.COLOR_BayerRGGB2RGB,
    "bggr": cv2.COLOR_BayerBGGR2RGB,
    "gbrg": cv2.COLOR_BayerGBRG2RGB,
    "grbg": cv2.COLOR_BayerGRBG2RGB,
}

ENCODINGS = {
    **_in_8_and_16_bits("rgb", 3, None),
    **_in_8_and_16_bits("bgr", 3, cv2.COLOR_BGR2RGB),
    **_in_8_and_16_bits("rgba", 4, cv2.COLOR_RGBA2RGB),
    **_in_8_and_16_bits("bgra", 4, cv2.COLOR_BGRA2RGB),
    **_in_8_and_16_bits("mono", 1, cv2.COLOR_GRAY2RGB),
    "8UC1": Encoding(1, cv2.COLOR_GRAY2RGB),
    "16UC1": Encoding(1, cv2.COLOR_GRAY2RGB, 16),
    "8UC3": Encoding(3, cv2.COLOR_BGR2RGB),
    "16UC3": Encoding(3, cv2.COLOR_BGR2RGB, 16),
    "8UC4": Encoding(4, cv2.COLOR_BGRA2RGB),
    "16UC4": Encoding(4, cv2.COLOR_BGRA2RGB, 16),
    "yuv422": Encoding(2, cv2.COLOR_YUV2RGB_UYVY),
    "uyvy": Encoding(2, cv2.COLOR_YUV2RGB_UYVY),
    "yuv422_yuy2": Encoding(2, cv2.COLOR_YUV2RGB_YUY2),
    "yuyv": Encoding(2, cv2.COLOR_YUV2RGB_YUY2),
    **{
        name: encoding
        for order, to_rgb in _MOSAICS.items()
        for name, encoding in _in_8_and_16_bits(f"bayer_{order}", 1, to_rgb).items()
    },
}
