# SPDX-License-Identifier: Apache-2.0
"""A page in headless Chromium, for tests."""

import base64
import http.client
import json
import os
import re
import shutil
import signal
import subprocess
import time
from contextlib import ExitStack, suppress

import pytest
from websockets.sync.client import connect

BROWSERS = ("chromium", "chromium-headless-shell", "chromium-browser", "google-chrome")
PICTURE = "import('/state.js').then(({{ state: {{ picture }} }}) => {})"


class Browser:
    """One page in headless Chromium, driven through its DevTools protocol; a live one has shown a picture."""

    def __init__(self, folder, url, width=1400, *, live=True, at=None, profile="browser"):
        """Open an address, which may lead to another one, `at`."""
        found = next(filter(None, map(shutil.which, BROWSERS)), None)
        if found is None:
            pytest.skip(f"needs a browser: none of {', '.join(BROWSERS)} is installed")
        log = folder / "browser.log"
        words = ["--headless", "--no-sandbox", "--disable-gpu", f"--window-size={width},860"]
        with log.open("wb") as stream:
            self._process = subprocess.Popen(
                [found, *words, "--remote-debugging-port=0", f"--user-data-dir={folder / profile}", url],
                stdout=stream,
                stderr=stream,
                start_new_session=True,
            )
        self._open, self._live = ExitStack(), live
        try:
            self._connect(log, at or url)
        except BaseException:
            self.close()
            raise

    def _connect(self, log, url):
        text = until(lambda: re.search(r"ws://([\d.:]+)/", log.read_text("utf-8", "replace")), "the browser")

        def pages():
            return [
                page for page in json.loads(get(text[1], "/json")[1]) if page["url"].startswith(url.partition("#")[0])
            ]

        self._target = until(pages, "the page")[0]["webSocketDebuggerUrl"]
        self._socket = self._open.enter_context(connect(self._target, max_size=None))
        self._number = 0
        until(self._is_shown, "the page, and its first picture")

    def _is_shown(self):
        """While the page still loads, its context comes and goes, and a question may find none."""
        shows = "performance.getEntriesByType('navigation')[0]?.loadEventEnd > 0"
        shows += f" && {PICTURE.format('picture !== null')}" * self._live
        return self._is_true(shows)

    def _is_true(self, expression):
        answer = self._ask("Runtime.evaluate", expression=expression, awaitPromise=True)
        return answer.get("result", {}).get("result", {}).get("value") is True

    def _ask(self, method, **given):
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": given}))
        while (answer := json.loads(self._socket.recv(timeout=30.0))).get("id") != self._number:
            pass
        return answer

    def _call(self, method, **given):
        answer = self._ask(method, **given)
        assert "error" not in answer, answer
        return answer["result"]

    def value(self, expression):
        """Value of an expression on the page."""
        answer = self._call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def reload(self):
        """Load the page again; while it is left, a question may find none."""
        self.value("window.before = true, location.reload()")
        until(lambda: self._is_true("window.before === undefined") and self._is_shown(), "the page again")

    def picture(self, expression):
        """Value of an expression of `picture`, what the server sent last."""
        return self.value(PICTURE.format(expression))

    def press(self, key, code):
        """Press and release a key."""
        for kind in ("keyDown", "keyUp"):
            text = {"Enter": "\r"}.get(key, "")
            self._call("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code, text=text)

    def type(self, name, text):
        """Type into an entry as on a keyboard, and press Enter."""
        self.value(f"document.getElementById('{name}').focus(), document.getElementById('{name}').select()")
        self._call("Input.insertText", text=text)
        self.press("Enter", 13)

    def click(self, name):
        self.value(f"document.getElementById('{name}').click()")

    def width(self, width, height=844):
        """Change the size of the window."""
        self._call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 500
        )

    def on_paper(self):
        """Show the page as it is printed."""
        self._call("Emulation.setEmulatedMedia", media="print")

    def text(self, name):
        return self.value(f"document.getElementById('{name}').textContent")

    def slide(self, name, value):
        """Move a slider as a hand does."""
        self.value(
            f"(s => {{ s.value = {value}; s.dispatchEvent(new Event('input')); }})(document.getElementById('{name}'))"
        )

    def drawn(self, name):
        """Share of a canvas that is drawn on."""
        return self.value(
            f"(c => {{ const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0;"
            f"for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return n / (c.width * c.height); }})"
            f"(document.getElementById('{name}'))"
        )

    def screenshot(self, path):
        path.write_bytes(base64.b64decode(self._call("Page.captureScreenshot")["data"]))

    def end(self):
        """Close as a user does, so that it writes what it keeps."""
        self._ask("Browser.close")
        self._process.wait(30.0)

    def tab(self, url):
        """Open another tab, which `self` then stands for."""
        made = self._call("Target.createTarget", url=url)["targetId"]
        found = re.sub(r"page/\w+$", f"page/{made}", self._target)
        self._target, self._socket = found, self._open.enter_context(connect(found, max_size=None))
        until(self._is_shown, "the page, and its first picture")

    def close(self):
        self._open.close()
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)  # it has many children
        self._process.wait()


def get(place, path, **headers):
    """Status and content of a path at HOST:PORT."""
    connection = http.client.HTTPConnection(place, timeout=10.0)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    return answer.status, answer.read()


def until(happened, what, seconds=40.0):
    end = time.monotonic() + seconds
    while not (found := happened()):
        assert time.monotonic() < end, f"waited {seconds} s for {what}"
        time.sleep(0.05)
    return found
