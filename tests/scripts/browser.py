"""A headless Chromium, driven over a pipe by its DevTools protocol."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# Without a graphics card the pictures of WebGL are computed; and nothing is asked of other hosts.
OPTIONS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
           "--ignore-gpu-blocklist", "--disable-quic", "--no-first-run", "--disable-background-networking",
           "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--mute-audio",
           "--hide-scrollbars", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost",
           "--remote-debugging-pipe"]  # fmt: skip
LOADING = 300.0  # s, by a busy machine


def chromium() -> str | None:
    """Return the browser's program; None where there is none."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


class Browser:
    """A browser with one page.

    Attributes
    ----------
    console : list of str
        What the page has said so far.
    """

    def __init__(self, program: str, folder: Path, width: int, height: int) -> None:
        self.console: list[str] = []
        commands, self._commands = os.pipe()
        self._answers, answers = os.pipe()
        words = [
            program,
            *OPTIONS,
            f"--user-data-dir={folder}",
            f"--window-size={width},{height}",
            "about:blank",
        ]

        def on_three_and_four() -> None:
            # By way of higher numbers, since one may be the other's.
            a, b = os.dup(commands), os.dup(answers)
            os.dup2(a, 3)
            os.dup2(b, 4)

        with (folder / "chromium.err").open("wb") as errors:
            self._process = subprocess.Popen(
                words, stdin=subprocess.DEVNULL, stdout=errors, stderr=errors, pass_fds=(3, 4),
                preexec_fn=on_three_and_four, start_new_session=True,
            )  # fmt: skip
        os.close(commands)
        os.close(answers)
        self._number, self._session, self._rest, self._loaded = 0, "", b"", False
        page = self.ask("Target.createTarget", url="about:blank")
        attached = self.ask("Target.attachToTarget", targetId=page["targetId"], flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable")

    def ask(self, method: str, *, timeout: float = LOADING, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its result."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            for answer in self._read(end):
                if answer.get("id") == self._number:
                    assert "error" not in answer, f"{method}: {answer['error']}"
                    result: dict[str, Any] = answer["result"]
                    return result
                self._listen(answer)
        raise TimeoutError(f"the browser did not answer {method}")

    def go(self, address: str) -> None:
        """Open a page, and wait until it is loaded."""
        self._loaded = False
        found = self.ask("Page.navigate", url=address)
        assert not found.get("errorText"), found
        end = time.monotonic() + LOADING
        while not self._loaded:
            assert time.monotonic() < end, f"{address} was not loaded: {self.console[-20:]}"
            for event in self._read(end):
                self._listen(event)

    def worked(self) -> float:
        """Return the processor time, s, of all of the browser's processes so far."""
        ticks = 0
        for status in Path("/proc").glob("[0-9]*/stat"):
            try:
                fields = status.read_text().rpartition(")")[2].split()
            except OSError:  # it has ended meanwhile
                continue
            if int(fields[2]) == self._process.pid:  # of its process group
                ticks += int(fields[11]) + int(fields[12])
        return ticks / os.sysconf("SC_CLK_TCK")

    def screenshot(self, file: Path) -> None:
        """Write what is to be seen into a PNG."""
        file.write_bytes(base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"]))

    def close(self) -> None:
        """End the browser, and all processes that it started."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait(10)
        os.close(self._commands)
        os.close(self._answers)

    def _read(self, end: float) -> list[dict[str, Any]]:
        ready, _, _ = select.select([self._answers], [], [], max(0.0, end - time.monotonic()))
        if not ready:
            return []
        some = os.read(self._answers, 1 << 20)
        assert some, "the browser has ended"
        *whole, self._rest = (self._rest + some).split(b"\0")
        return [json.loads(part) for part in whole]

    def _listen(self, event: dict[str, Any]) -> None:
        said = event.get("params", {})
        if event.get("method") == "Page.loadEventFired":
            self._loaded = True
        elif event.get("method") == "Runtime.consoleAPICalled":
            self.console.append(" ".join(str(a.get("value", "")) for a in said["args"]))
        elif event.get("method") == "Log.entryAdded":
            self.console.append(f"{said['entry']['level']}: {said['entry']['text']}")
