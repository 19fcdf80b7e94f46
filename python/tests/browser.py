"""Headless Chromium, driven by chromedriver (W3C WebDriver) with the standard library alone."""

import base64
import json
import shutil
import socket
import struct
import subprocess
import tempfile
import threading
import time
import urllib.request
import zlib

import numpy as np

OPTIONS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--window-size=900,600",
]


def is_there():
    return all(map(shutil.which, ("chromium", "chromedriver")))


class Listener:
    """Acts as a proxy of the browser, and records all requests."""

    def __init__(self):
        self.asked = []
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.port = self._socket.getsockname()[1]
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                return
            with connection:
                connection.settimeout(2.0)
                try:
                    self.asked.append(connection.recv(4096).split(b"\r\n")[0].decode(errors="replace"))
                    connection.sendall(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
                except OSError:
                    continue

    def close(self):
        self._socket.close()


class Browser:
    """Page of Chromium whose requests all go to a listener."""

    def __init__(self):
        self.listener = Listener()
        self._directory = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        self._address = f"http://127.0.0.1:{port}"
        self._driver = subprocess.Popen(
            ["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self._wait_for_driver()
        arguments = [*OPTIONS, f"--user-data-dir={self._directory.name}"]
        arguments += [f"--proxy-server=127.0.0.1:{self.listener.port}", "--proxy-bypass-list=<-loopback>"]
        options = {"args": arguments, "binary": shutil.which("chromium")}
        logs = {"performance": "ALL"}
        capabilities = {"alwaysMatch": {"goog:chromeOptions": options, "goog:loggingPrefs": logs}}
        self._session = self._ask("POST", "/session", {"capabilities": capabilities})["sessionId"]

    def _wait_for_driver(self):
        for _ in range(200):
            try:
                self._ask("GET", "/status")
                return
            except OSError:
                time.sleep(0.05)
        raise AssertionError("chromedriver does not answer")

    def _ask(self, method, path, content=None):
        data = None if content is None else json.dumps(content).encode()
        request = urllib.request.Request(
            self._address + path, data, {"Content-Type": "application/json"}, method=method
        )
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        with opener.open(request, timeout=60) as answer:
            return json.load(answer)["value"]

    def _do(self, path, content):
        return self._ask("POST", f"/session/{self._session}{path}", content)

    def open(self, path):
        self._do("/url", {"url": path.as_uri()})

    def run(self, script):
        """Runs a script and returns its result."""
        return self._do("/execute/sync", {"script": script, "args": []})

    def enter_frame(self, index=0):
        self._do("/frame", {"id": index})

    def leave_frame(self):
        self._do("/frame", {"id": None})

    def wait_until(self, condition):
        for _ in range(200):
            if self.run(f"return {condition}"):
                return
            time.sleep(0.05)
        raise AssertionError(
            f"not so after 10 s: {condition}; the page says: " + str(self.run("return document.body.innerText"))
        )

    def requests(self):
        """Returns the addresses that pages have requested since the last call."""
        entries = self._do("/se/log", {"type": "performance"})
        messages = [json.loads(entry["message"])["message"] for entry in entries]
        sent = [
            message["params"]["request"]["url"]
            for message in messages
            if message["method"] == "Network.requestWillBeSent"
        ]
        return [address for address in sent if not address.startswith("data:")]

    def drag(self, x, y):
        """Drags the middle of the page by x and y pixels."""
        move = {"type": "pointerMove", "origin": "viewport", "duration": 100}
        steps = [
            {**move, "x": 450, "y": 250},
            {"type": "pointerDown", "button": 0},
            {**move, "x": 450 + x, "y": 250 + y},
            {"type": "pointerUp", "button": 0},
        ]
        mouse = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": steps}
        self._do("/actions", {"actions": [mouse]})

    def screenshot(self):
        """Returns the page as a PNG file."""
        return base64.b64decode(self._ask("GET", f"/session/{self._session}/screenshot"))

    def pixels(self):
        """Returns the pixels of the page, (height, width, 3) uint8."""
        return pixels(self.screenshot())

    def close(self):
        try:
            self._ask("DELETE", f"/session/{self._session}")
        finally:
            self._driver.terminate()
            self._driver.wait(10)
            self.listener.close()
            self._directory.cleanup()


def pixels(png):
    """Decodes a PNG file with eight bits per channel and without interlacing. Returns (height, width, 3) uint8."""
    offset, data = 8, b""
    while offset < len(png):
        (length,), kind = struct.unpack(">I", png[offset : offset + 4]), png[offset + 4 : offset + 8]
        content = png[offset + 8 : offset + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlace = struct.unpack(">IIBBBBB", content)
            assert depth == 8 and color in (2, 6) and not interlace
        elif kind == b"IDAT":
            data += content
        offset += 12 + length
    channels = 3 if color == 2 else 4
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + width * channels)
    before = np.zeros((width, channels), np.uint8)
    image = np.empty((height, width, channels), np.uint8)
    for index, row in enumerate(rows):
        before = image[index] = _unfiltered(int(row[0]), row[1:].reshape(width, channels), before)
    return image[..., :3]


def _unfiltered(kind, row, above):
    """Removes the filter of a row of a PNG file."""
    if kind == 0:
        return row
    if kind == 1:
        return np.cumsum(row, axis=0, dtype=np.uint8)
    if kind == 2:
        return row + above
    unfiltered, width = [], row.shape[1]
    left = corner = [0] * width
    # Python integers are faster here than arrays of three numbers.
    for values, up in zip(row.tolist(), above.tolist(), strict=True):
        guesses = map(_mean, left, up) if kind == 3 else map(_paeth, left, up, corner)
        left, corner = [(value + guess) & 255 for value, guess in zip(values, guesses, strict=True)], up
        unfiltered.append(left)
    return np.array(unfiltered, np.uint8)


def _mean(left, up):
    return (left + up) // 2


def _paeth(left, up, corner):
    """Returns the value that is closest to left + up - corner."""
    far_left, far_up, far_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
    if far_left <= far_up and far_left <= far_corner:
        return left
    return up if far_up <= far_corner else corner
