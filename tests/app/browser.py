"""A headless Chromium driven through its debugging pipe; no driver package is needed.

For tests, and for the pictures of the page in the documents.
"""

from __future__ import annotations

import base64
import json
import os
import shlex
import shutil
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

EXECUTABLE = next(
    (
        path
        for name in ("chromium", "chromium-browser", "google-chrome")
        if (path := shutil.which(name))
    ),
    None,
)
"""Of the browser; None where there is none."""

STAGE = "([...document.querySelectorAll('.stage')].find(one => one.offsetParent) || {dataset: {}})"
SHOWN, NOTHING_SHOWN = (f"{STAGE}.dataset.shown == {one!r}" for one in ("all", "nothing"))
"""Whether the stage that is seen shows a recording with all that is known of it, or none."""

NAME = "document.querySelector('.stage-title strong')"
"""What the recording on the Ask tab is called."""

UPLOADS = (
    "performance.getEntriesByType('resource')"
    ".filter(one => /\\/upload(\\?|$)/.test(one.name)).length"
)
"""How many uploads the page has ended."""

TEXT = "document.body.innerText"
CHAT = "[...document.querySelectorAll('.talk-list')].find(one => one.offsetParent)"
COMPLAINT = "[...document.querySelectorAll('.complaint')].find(one => one.offsetParent)"
"""Parts of the tab that is seen; there is no complaint where it is empty."""


class Browser:
    """One page of one browser.

    Args:
        profile: An empty folder for what the browser keeps.
        size: Width and height of the page.
        flags: More of the browser's own, for example for a camera that plays a file.
    """

    def __init__(
        self, profile: Path, size: tuple[int, int] = (1400, 1100), flags: Sequence[str] = ()
    ) -> None:
        to_read, self._to_write = os.pipe()
        self._from_read, to_write = os.pipe()
        given = ["--headless=new", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe"]
        given += [f"--user-data-dir={profile}", "--no-first-run", "--hide-scrollbars"]
        given += [f"--window-size={size[0]},{size[1]}", "--disable-dev-shm-usage"]
        words = shlex.join([str(EXECUTABLE), *given, *flags, "about:blank"])
        command = f"exec 3<&{to_read} 4>&{to_write}; exec {words}"
        self._process = subprocess.Popen(
            ["bash", "-c", command],
            pass_fds=(to_read, to_write),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(to_write)
        self._received, self._number, self._session = b"", 0, None
        self._context: str | None = None
        self.renew(size)

    def renew(self, size: tuple[int, int] = (1400, 1100)) -> None:
        """Close the page, and begin anew with an empty one that knows nothing of it."""
        self._session = None
        if self._context is not None:
            self.call("Target.disposeBrowserContext", browserContextId=self._context)
        self._context = self.call("Target.createBrowserContext")["browserContextId"]
        page = self.call("Target.createTarget", url="about:blank", browserContextId=self._context)[
            "targetId"
        ]
        attached = self.call("Target.attachToTarget", targetId=page, flatten=True)
        self._session = attached["sessionId"]
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **metrics)
        # A window that nobody looks at has no focus, and its fields would never be left.
        self.call("Emulation.setFocusEmulationEnabled", enabled=True)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send one command of the debugging protocol and return its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to_write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def _receive(self) -> dict[str, Any]:
        while b"\0" not in self._received:
            part = os.read(self._from_read, 1 << 16)
            if not part:
                raise RuntimeError("the browser ended")
            self._received += part
        message, self._received = self._received.split(b"\0", 1)
        return json.loads(message)

    def run(self, script: str) -> Any:
        """Return the value of a JavaScript expression in the page."""
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"]["text"])
        return result["result"].get("value")

    def wait_for(self, script: str, seconds: float = 180.0) -> Any:
        """Wait until an expression is true, and return its value."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            if value := self.run(script):
                return value
            time.sleep(0.1)
        raise TimeoutError(f"{script} was not true within {seconds:g} s")

    def open(self, address: str) -> None:
        """Show a page and wait until its first example is shown, and it answers to clicks."""
        self.call("Page.navigate", url=address)
        self.wait_for(f"{SHOWN} && !document.body.innerText.includes('Loading...')", seconds=300.0)

    def open_example(self, name: str) -> None:
        """Click an example and wait until it is shown with what the model reads in it."""
        self.click(name, "button.example")
        self.wait_for(f"{SHOWN} && {NAME}.innerText == {name!r}")

    def open_recording(self, path: Path) -> None:
        """Upload a recording on the Ask tab and wait until it is shown likewise."""
        self.upload("Recording", path)
        self.wait_for(f"{SHOWN} && {NAME}.innerText == {path.name!r}")

    def click(self, text: str, kind: str = "button") -> None:
        """Click the first visible element of a kind that holds a text."""
        self.wait_for(
            f"(() => {{ const one = [...document.querySelectorAll({kind!r})].find("
            f"e => e.offsetParent && e.innerText.includes({text!r})); "
            "if (!one) return false; one.click(); return true; })()"
        )

    def fill(self, label: str, text: str) -> None:
        """Type a text into the field of a label that begins so."""
        self.wait_for(
            "(() => { const box = [...document.querySelectorAll('label')].filter("
            f"one => one.offsetParent && one.innerText.trim().startsWith({label!r}))"
            ".map(one => one.querySelector('textarea, input')).find(one => one);"
            f"if (!box) return false; box.value = {text!r};"
            "box.dispatchEvent(new Event('input', {bubbles: true})); return true; })()"
        )

    def ask(self, question: str) -> None:
        """Ask a question and wait until it stands in the conversation with its answer."""
        asked = f"{CHAT}.innerText.split({question!r}).length"
        before = self.run(asked)
        self.fill("Question", question)
        self.click_until("Ask", f"{asked} > {before}", "button.primary")

    def click_until(
        self, text: str, sign: str, kind: str = "button", fields: dict[str, str] | None = None
    ) -> None:
        """Click until an expression is true: a click while another still works is passed over.

        A field that was just laid out may forget what it was given: it is filled before each click.
        """
        until = time.monotonic() + 60
        while not self.run(sign):
            if time.monotonic() > until:
                raise TimeoutError(f"{sign} was not true however often {text} was clicked")
            for label, value in (fields or {}).items():
                self.fill(label, value)
            self.click(text, kind)
            time.sleep(0.1)

    def upload(self, label: str, path: Path) -> None:
        """Give a file to the visible upload field of a label, and wait until the page has it."""
        find = (
            "[...document.querySelectorAll('input[type=file]')].find(one => {"
            "let e = one; while (e && !e.offsetParent) e = e.parentElement;"
            f"while (e && !e.innerText.includes({label!r})) e = e.parentElement;"
            "return e && e.querySelectorAll('input[type=file]').length == 1; })"
        )
        self.wait_for(f"Boolean({find})")
        field = self.call("Runtime.evaluate", expression=find)["result"]["objectId"]
        # The name is shown while the file is still on its way: a click would then find none.
        self.run("performance.setResourceTimingBufferSize(9999)")
        before = self.run(UPLOADS)
        self.call("DOM.setFileInputFiles", files=[str(path)], objectId=field)
        self.wait_for(f"{UPLOADS} > {before}", 20)

    def press(self, key: str, code: int, text: str = "") -> None:
        """Press and let go of a key, for whatever has the focus."""
        about = {"key": key, "code": key, "windowsVirtualKeyCode": code}
        self.call("Input.dispatchKeyEvent", type="keyDown", text=text, **about)
        self.call("Input.dispatchKeyEvent", type="keyUp", **about)

    def screenshot(self, path: Path) -> None:
        """Write what is seen to a .png file."""
        image = self.call("Page.captureScreenshot", format="png")["data"]
        path.write_bytes(base64.b64decode(image))

    def close(self) -> None:
        """End the browser."""
        self._process.terminate()
        self._process.wait(timeout=30)
        os.close(self._to_write)
        os.close(self._from_read)
