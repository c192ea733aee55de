"""`flexsim view --web` shows a recorded robot in a real browser; its picture stays in out/view_web.png."""

from __future__ import annotations

import json
import re
import signal
import time
import urllib.request
from pathlib import Path

import numpy as np
import pytest
from browser import Browser, chromium
from flexsim.rerun_view.palette import SERIES
from matplotlib.image import imread
from numpy.typing import NDArray
from processes import Background, Recorded, command, ros_environment, synthetic_robot

# Without a graphics card a browser needs all of the processor.
pytestmark = [pytest.mark.ros, pytest.mark.alone]

ARTEFACTS = Path(__file__).parents[2] / "out"
WIDTH, HEIGHT = 1280, 800
# s that the browser may compute until all is drawn: on a busy machine that takes longer, not more.
PATIENCE = 120.0
LONGEST = 600.0  # s, in any case
LISTEN, LOOPBACK = "0A", "0100007F"


def listeners(port: int) -> list[str]:
    """Return the addresses that a port of this host listens on, as the system writes them."""
    found = []
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            _, local, _, state, *_ = line.split()
            address, number = local.split(":")
            if state == LISTEN and int(number, 16) == port:
                found.append(address)
    return found


def pixels(picture: NDArray, colour: tuple[int, int, int]) -> int:
    """Count the pixels of a picture that have a colour."""
    off = np.abs(picture[:, :, :3] * 255.0 - np.array(colour))
    return int(np.sum(off.max(axis=2) < 8.0))


@pytest.fixture
def page(tmp_path: Path) -> Browser:
    """Open a browser; skip where there is none."""
    program = chromium()
    if program is None:
        pytest.skip("no Chromium is installed (Debian: apt-get install chromium; .ci/run does)")
    browser = Browser(program, tmp_path, WIDTH, HEIGHT)
    yield browser
    browser.close()


def test_a_recorded_run_in_a_browser(recorded: Recorded, page: Browser, tmp_path: Path) -> None:
    """The page draws the joints, each line in its colour; it is served on loopback, and ends with us."""
    words = command("view", recorded.bag, "--web", "--json")
    view = Background(words, ros_environment(), tmp_path)
    try:
        view.wait_for("look at it in a browser")
        found = json.loads(view.output.read_text())
        address = found["page"]
        ports = [int(port) for port in re.findall(r"127\.0\.0\.1(?::|%3A)(\d+)", address)]
        assert len(set(ports)) == 2
        assert [listeners(port) for port in ports] == [[LOOPBACK], [LOOPBACK]]

        page.go(f"{address}&renderer=webgl")
        ARTEFACTS.mkdir(exist_ok=True)
        file = ARTEFACTS / "view_web.png"
        file.unlink(missing_ok=True)
        begun, seen = time.monotonic(), {}
        wanted = {"joint_1": SERIES[0], "joint_2": SERIES[1], "joint_3": SERIES[2]}
        while page.worked() < PATIENCE and time.monotonic() - begun < LONGEST:
            page.screenshot(file)
            picture = imread(file)
            seen = {name: pixels(picture, colour) for name, colour in wanted.items()}
            if min(seen.values()) > 150:
                break
            time.sleep(1.0)
        # A line across a plot has some hundred pixels; the page before the data has none of them.
        assert min(seen.values()) > 150, f"{seen}: {[words[:200] for words in page.console[-20:]]}"
        assert picture.shape[0] > HEIGHT / 2 and picture.shape[1] > WIDTH / 2
    finally:
        code = view.end(signal.SIGINT)
    assert code == 0, view.errors.read_text()
    assert [listeners(port) for port in ports] == [[], []]


def test_a_running_robot_on_a_page(tmp_path: Path) -> None:
    """The page is there while the robot runs, is of this host alone, and is gone afterwards."""
    environment = ros_environment()
    scene = tmp_path / "scene.yaml"
    scene.write_text("model: robot\n")
    robot = synthetic_robot(environment, tmp_path, 300, 300.0, "--for-view")
    view = Background(command("view", scene, "--web", "--json"), environment, tmp_path)
    view.wait_for("showing on http://")
    said = view.errors.read_text()
    address = re.search(r"showing on (\S+);", said)[1]
    ports = [int(port) for port in re.findall(r"127\.0\.0\.1(?::|%3A)(\d+)", address)]
    assert [listeners(port) for port in ports] == [[LOOPBACK], [LOOPBACK]]
    with urllib.request.urlopen(address, timeout=20) as answer:
        assert b"rerun" in answer.read()
    robot.wait_for("published")
    assert view.end() == 0, view.errors.read_text()
    robot.release()
    assert json.loads(view.output.read_text())["rows"]["robot/tip/deflection"] == 300
    assert [listeners(port) for port in ports] == [[], []]
