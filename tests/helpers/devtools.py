"""A headless Chromium that does what a reader does, by its DevTools protocol."""

import base64
import json
import shutil
import subprocess
import time
from contextlib import contextmanager
from urllib.request import urlopen

import pytest
from tornado.ioloop import IOLoop
from tornado.websocket import websocket_connect

OPTIONS = "--headless --no-sandbox --disable-gpu --no-first-run --remote-debugging-port=0"
#: Longest time that a page may take to become what is awaited [s].
LONGEST = 60.0


class Browser:
    """A page in Chromium."""

    def __init__(self, address):
        self.loop, self.number, self.messages = IOLoop(), 0, []
        self.socket = self._run(websocket_connect(address, max_message_size=1 << 28))
        for domain in ("Page", "Runtime", "Log"):
            self.send(f"{domain}.enable")

    def _run(self, awaitable):
        async def waited():
            return await awaitable

        return self.loop.run_sync(waited, timeout=LONGEST)

    def send(self, method, **parameters):
        """The result of a command of the protocol."""
        self.number += 1
        content = {"id": self.number, "method": method, "params": parameters}
        self._run(self.socket.write_message(json.dumps(content)))
        while True:
            answer = json.loads(self._run(self.socket.read_message()))
            if answer.get("id") == self.number:
                assert "error" not in answer, answer
                return answer["result"]
            self.messages.append(answer)

    def open(self, path):
        """Open a file."""
        self.send("Page.navigate", url=path.as_uri())

    def value(self, script):
        """The value of an expression of JavaScript in the page."""
        found = self.send(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def until(self, script):
        """The value of an expression as soon as it is true."""
        end = time.monotonic() + LONGEST
        while not (value := self.value(script)):
            assert time.monotonic() < end, f"never: {script}"
            time.sleep(0.02)
        return value

    def picture(self, path, width=1200, height=1000, **more):
        """Save what the page shows in a window of this size."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.send("Emulation.setDeviceMetricsOverride", **size, **more)
        time.sleep(0.3)
        shown = self.send("Page.captureScreenshot", captureBeyondViewport=False)
        path.write_bytes(base64.b64decode(shown["data"]))

    @property
    def complaints(self):
        """What the console and the log of the page said."""
        kinds = "Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled"
        return [one for one in self.messages if one.get("method") in kinds]


@contextmanager
def chromium(folder):
    """A browser with its profile in a folder; the test is skipped where there is none."""
    if (program := shutil.which("chromium")) is None:
        pytest.skip("no chromium on the PATH")
    profile = folder / "profile"
    command = [program, *OPTIONS.split(), f"--user-data-dir={profile}", "about:blank"]
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, stdout=quiet, stderr=quiet) as process:
        try:
            port, end = profile / "DevToolsActivePort", time.monotonic() + LONGEST
            while not port.exists() or not port.read_text().strip():
                assert time.monotonic() < end, "Chromium did not start"
                time.sleep(0.05)
            number = port.read_text().split()[0]
            with urlopen(f"http://127.0.0.1:{number}/json/list") as answer:
                pages = [one for one in json.load(answer) if one["type"] == "page"]
            yield Browser(pages[0]["webSocketDebuggerUrl"])
        finally:
            process.kill()
