"""A camera in the place of OpenCV's, for `cv2.VideoCapture`."""

import threading
import time


class FakeCamera:
    """Gives BGR frames, and then none: it ends, fails with an error, or waits until released.

    With `pace` it shows so many a second by the machine's clock.
    """

    def __init__(self, frames, fps=25.0, *, pace=None, error=None, waits=False):
        self.left, self.fps, self.pace = list(frames), fps, pace
        self.error, self.waits, self.released = error, waits, threading.Event()
        self.begin_s, self.shown = time.monotonic(), -1

    def isOpened(self):  # noqa: N802
        return True

    def grab(self):
        return bool(self.left) or self.released.wait(60 if self.waits else 0)

    def get(self, name):
        return self.fps

    def read(self):
        self.shown += 1
        if self.pace is not None:
            time.sleep(max(self.begin_s + self.shown / self.pace - time.monotonic(), 0))
        if self.left:
            return True, self.left.pop(0)
        if self.error is not None:
            raise self.error
        self.released.wait(60 if self.waits else 0)
        return False, None

    def release(self):
        self.released.set()
