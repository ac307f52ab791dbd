"""What was seen of a stream, as a video: arrows over the frames, the last event as a caption."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import UsageError
from geotlm_lm.live.events import MotionEvent
from geotlm_lm.recordings.video import quiet_capture
from geotlm_lm.views.pictures import draw_arrows, draw_legend, magnified

CAPTION_ROWS = 32
"""Pixels of the strip below the frame that holds the caption."""


class Film:
    """Writes a drawing of every frame to a video file, which appears when it is whole.

    Args:
        path: Of the .mp4 file; its folder is made if missing.
        fps: Frames per second.
    """

    def __init__(self, path: Path, fps: float) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)  # a video's writer makes no folder
        self._path, self._fps, self._caption = path, fps, ""
        self._writer: cv2.VideoWriter | None = None
        self._part = path.with_name(f".{path.stem}.{os.getpid()}-{os.urandom(4).hex()}.mp4")
        self._written = 0

    def add(self, frame: Frames, events: list[MotionEvent], perceived: Any) -> None:
        """Draw the next frame.

        Args:
            frame: uint8 RGB, all of one size.
            events: What began or ended with it.
            perceived: The `Encoded` of the last window; None where nothing touched.

        Raises:
            UsageError: If the file cannot be written.
        """
        if events:
            self._caption = events[-1].sentence().strip()
        image = magnified(frame)
        if perceived is not None:
            geometry = perceived.perception.geometry
            field, mask = (np.asarray(x[0]) for x in (geometry.shear_change, geometry.mask))
            image = draw_arrows(image, field, mask, perceived.view)
            image = draw_legend(image, perceived.view)
        image = cv2.copyMakeBorder(image, 0, CAPTION_ROWS, 0, 0, cv2.BORDER_CONSTANT)
        place = (8, image.shape[0] - 10)
        white = (255, 255, 255)
        cv2.putText(image, self._caption, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, white, 1)
        # The codec halves the colours' resolution: odd sizes cannot be written.
        image = image[: image.shape[0] // 2 * 2, : image.shape[1] // 2 * 2]
        if self._writer is None:
            self._writer = self._open(image.shape[1], image.shape[0])
        self._writer.write(cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
        self._written += 1

    def close(self) -> None:
        """Finish the file and put it in its place.

        Raises:
            UsageError: If it is not whole: the codec says nothing of a disk that is full.
        """
        if self._writer is None:
            return
        self._writer.release()
        self._writer = None
        if self._is_whole():
            self._part.replace(self._path)
            return
        self._part.unlink(missing_ok=True)
        raise UsageError(
            f"--draw: {self._path} could not be written whole; free some room on the disk, or give "
            f"a name on another one."
        )

    def _is_whole(self) -> bool:
        with quiet_capture(str(self._part), cv2.CAP_FFMPEG) as capture:
            declared = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
            capture.set(cv2.CAP_PROP_POS_FRAMES, self._written - 1)
            return declared == self._written and capture.grab()

    def _open(self, columns: int, rows: int) -> cv2.VideoWriter:
        code = cv2.VideoWriter_fourcc(*"mp4v")
        writer = cv2.VideoWriter(str(self._part), code, self._fps, (columns, rows))
        if not writer.isOpened():
            self._part.unlink(missing_ok=True)
            raise UsageError(f"--draw: {self._path} cannot be written as video; give another name.")
        return writer
