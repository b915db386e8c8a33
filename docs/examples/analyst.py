# SPDX-License-Identifier: Apache-2.0
"""An analyst's script: run a scene at three speeds, compare the whirl, keep one run as a bag and a figure.

Usage: analyst.py [SECONDS [FOLDER]]
"""

import sys
from pathlib import Path

import numpy as np

import drill_twin as dt


def largest_offset(result: dt.Result) -> float:
    """Largest distance of any mark's centre line from the axis [m]."""
    return float(np.hypot(result.centre[..., 0], result.centre[..., 1]).max())


def main(seconds: float = 20.0, folder: Path = Path("out/analyst")) -> None:
    """Run and compare."""
    results: dict[str, dt.Result] = {}
    for speed in ("90 rpm", "120 rpm", "150 rpm"):
        scene = dt.load_scene("pa6_bench", {"rig.rotation.value": speed, "wob": 60})
        results[speed] = result = dt.Simulation(scene).run(duration=seconds)
        onset = "no whirl" if result.onset_s is None else f"whirl from {result.onset_s:.2f} s"
        print(
            f"{speed}: {onset}, at most {1e3 * largest_offset(result):.1f} mm off the axis, "
            f"hookload {result.hookload.min():.2f} to {result.hookload.max():.2f} N"
        )

    last = results["150 rpm"]
    folder.mkdir(parents=True, exist_ok=True)
    last.plot_displacement().savefig(folder / "displacement.png")
    again = dt.read_bag(last.to_bag(folder / "bag_0"))
    assert np.array_equal(again.marks.position, last.marks.position)

    # Anyone's measurement is analysed by the same code: here the positions of one mark, as plain arrays.
    x, y = last.centre[:, 1, 0], last.centre[:, 1, 1]
    whirl = dt.analyze(last.time, x, y, last.rig.top_drive_speed, clearance="81.75 mm")
    for period in whirl.motion:
        print(f"{period['start_s']:6.2f} s to {period['end_s']:6.2f} s: {period['state']}")


if __name__ == "__main__":
    arguments = sys.argv[1:]
    main(float(arguments[0]) if arguments else 20.0, Path(arguments[1]) if len(arguments) > 1 else Path("out/analyst"))
