"""Draw the pictures of docs/reports.md: reports of three robots in a headless browser, and a figure.

``python scripts/report_pictures.py [BROWSER]`` needs Chromium and the extra ``report``. The browser
may reach nothing: it is given a proxy that does not exist, and the pages forbid every request themselves.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from benchmark_cases import COGIRO, MERLET

from cdpr_interval import load_robot
from solvers import forward_kinematics
from solvers.report.page import result_page
from solvers.report.source import ResultSource

PICTURES = Path(__file__).parents[1] / "docs" / "pictures"
QUESTIONS = {"merlet_4_1": MERLET, "uc3": ["7.5", "8", "7"], "cogiro": COGIRO.split(",")}
SIZE = "1200,1150"
PATIENCE = 120
"""s for one picture."""
OPTIONS = (
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--proxy-server=127.0.0.1:9", "--use-gl=angle",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
    "--virtual-time-budget=15000",
)  # fmt: skip
"""The picture in 3-D needs WebGL, also where there is no graphics card."""


def main() -> None:
    """Write one PNG for each robot."""
    browser = sys.argv[1] if len(sys.argv) > 1 else "chromium"
    PICTURES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, lengths in QUESTIONS.items():
            robot = load_robot(name)
            result = forward_kinematics(robot, lengths, threads=2)
            page = Path(folder) / f"{name}.html"
            page.write_text(result_page(ResultSource(robot, result, None)), encoding="utf-8")
            picture = PICTURES / f"report_{name}.png"
            profile = f"--user-data-dir={folder}/profile"
            command = [browser, *OPTIONS, profile, f"--window-size={SIZE}", f"--screenshot={picture}"]
            subprocess.run([*command, page.as_uri()], check=True, timeout=PATIENCE, capture_output=True)
            print(f"{picture.relative_to(PICTURES.parents[1])}: {result.message}")


if __name__ == "__main__":
    main()
