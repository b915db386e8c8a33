# SPDX-License-Identifier: Apache-2.0
"""Runs each `ros2` line of the README and the pages with the real tools, and looks for what it must print.

    python .ci/ros2_lines.py            # a line each; exit code 1 if one prints something else

A line that starts nodes runs alone until it has printed its text, and is stopped by Ctrl-C. All others run beside a
twin, in the order of the table. `.ci/colcon` calls it in a workspace that is sourced; without `ros2` it says so.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Self

ROOT = Path(__file__).resolve().parents[1]
TWIN = "ros2 launch drill_twin twin.launch.py estimate:=true checkpoint:=run.npz"
GATEWAY = "ros2 run drill_twin gateway --ros-args -p signals:=dwis -p port:=4840"
BESIDE = {TWIN: "(?s)(?=.*driving: )(?=.*members of )", GATEWAY: "signals at opc.tcp://"}
"""What runs while the other lines do, and what it prints once it is there."""
DRIVES, WAITS = "driving: ", "time stands still until a command comes"
DONE, SET = "success=True", "Set parameter successful"
PRINTS = {
    "ros2 launch drill_twin twin.launch.py": DRIVES,
    "ros2 launch drill_twin twin.launch.py record:=true watch:=true": DRIVES,
    "ros2 launch drill_twin twin.launch.py scene:=pa6_bench record:=true": DRIVES,
    'ros2 launch drill_twin twin.launch.py accuracy:="1 %"': DRIVES,
    "ros2 launch drill_twin twin.launch.py namespace:=rig1 frame_prefix:=rig1/ record:=true bag:=out/rig1_0": DRIVES,
    "ros2 launch drill_twin twin.launch.py namespace:=rig2 frame_prefix:=rig2/ record:=true bag:=out/rig2_0": DRIVES,
    "ros2 launch drill_twin twin.launch.py estimate:=true"
    ' overrides:="effects.wall_friction.coefficient=0.3"'
    ' free:="wall_friction.coefficient=0.1..0.4; load_factor=0.8..1.2"': DRIVES,
    "ros2 run drill_twin simulator --ros-args -p pace:=lockstep -p duration:=10.0 &": WAITS,
    "ros2 run drill_twin simulator --ros-args -p checkpoint:=run.npz -p checkpoint_period:=5.0": WAITS,
    "ros2 run drill_twin recorder --ros-args -p bag:=out/bag_0 -p max_bagfile_size:=500.0"
    " -p max_bagfile_duration:=3600.0": r"recording \d+ topics to out/bag_0",
    GATEWAY: BESIDE[GATEWAY],
    "ros2 security create_keystore keys": "",
    "ros2 topic echo /whirl/motion": "name: 'motion: string'",
    'ros2 param set /rig_driver wob "60 N"': SET,
    'ros2 param set /rig_driver rpm "120 rpm"': SET,
    "ros2 topic echo /rig/commander": "data: /rig_driver",
    "ros2 topic echo /estimate/state": "- trust",
    'ros2 topic pub --once /rig/wob_command std_msgs/msg/Float64 "{data: 40.0}"': "publishing #1",
    'ros2 topic pub --once /rig/wob_command std_msgs/msg/Float64 "{data: 60.0}"': "publishing #1",
    'ros2 topic pub --once /rig/rps_command std_msgs/msg/Float64 "{data: 2.0}"': "publishing #1",
    "ros2 topic pub -r 10 /rig/command sensor_msgs/msg/JointState"
    ' "{header: {frame_id: me}, name: [bit_axial, top_drive],'
    ' effort: [40.0, .nan], velocity: [.nan, 12.566]}"': "publishing #3",
    "ros2 param set /simulator on_silence ramp": SET,
    "ros2 param set /simulator max_weight_on_bit 80.0": SET,
    "ros2 service call /simulator/pause std_srvs/srv/Trigger": DONE,
    "ros2 param set /simulator step_frames 10": SET,
    "ros2 service call /simulator/step std_srvs/srv/Trigger": DONE,
    "ros2 service call /simulator/resume std_srvs/srv/Trigger": DONE,
    "ros2 service call /simulator/reset std_srvs/srv/Trigger": DONE,
    "ros2 service call /simulator/save_checkpoint std_srvs/srv/Trigger": DONE,
    "ros2 service call /simulator/load_checkpoint std_srvs/srv/Trigger": DONE,
    "ros2 service call /gateway/grant_control std_srvs/srv/Trigger": "success=",
    "ros2 service call /gateway/withdraw_control std_srvs/srv/Trigger": "success=",
}
"""Expression that each documented line must print, by line."""
NEEDS = {
    "ros2 run drill_twin rig_driver --ros-args -p table:=well_7.csv": "a table of the reader's",
    "ros2 run drill_twin advisor --ros-args -p map:=out/map_pa6_bench/map.json": "a map",
    "ros2 launch drill_twin twin.launch.py advise:=true map:=$PWD/out/map_pa6_bench/map.json": "a map",
    "ros2 run drill_twin gateway --ros-args -p keys:=keys -p host:=0.0.0.0": "keys",
    "ros2 run drill_twin gateway --ros-args -p signals:=rig.yaml -p rig_url:=opc.tcp://rig:4840": "a rig",
    "ros2 run drill_twin estimator --ros-args -p scene:=my_well.yaml -p set_points:=measured"
    ' -p \'free:=["wall_friction.coefficient=0.1..0.4", "load_factor=0.8..1.2"]\'': "a rig",
    "ros2 launch drill_twin twin.launch.py"
    " drive:=false gateway:=true record:=true respawn:=true params_file:=rig.yaml": "a rig",
    "ros2 service call /replayer/pause std_srvs/srv/Trigger": "a replay",
    "ros2 param set /replayer rate 4.0": "a replay",
    "ros2 param set /replayer start_offset 3.5": "a replay",
    "ros2 security generate_artifacts -k keys"
    " -p simulator.policy.xml rig_driver.policy.xml analyzer.policy.xml recorder.policy.xml": "copies of the policies",
    "ros2 run drill_twin simulator --ros-args --enclave /drill_twin/simulator": "keys in the environment",
}
"""What is missing here for a line; its command is asked for its help."""
_LONG = 600.0  # s; a kernel may have to be compiled
_END = 60.0  # s from Ctrl-C to the end


def documented() -> list[str]:
    """Lines of the README and the pages that begin with `ros2`, lines that go on joined, without comments."""
    pages = (ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md")))
    text = "\n".join(page.read_text("utf-8").replace("\\\n", "") for page in pages)
    found = re.findall(r"^(?:\$ )?(ros2 .*?)(?:\s+#.*)?$", text, re.MULTILINE)
    return list(dict.fromkeys(" ".join(line.split()) for line in found))


class Running:
    """A line that runs, and its output in a file."""

    def __init__(self, line: str, folder: Path, domain: int) -> None:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "PYTHONUNBUFFERED": "1"}
        command, self._log = ["bash", "-c", line.removesuffix(" &")], folder / f"said_{time.monotonic_ns()}"
        with self._log.open("wb") as stream:
            self._process = subprocess.Popen(
                command, cwd=folder, env=environment, stdout=stream, stderr=subprocess.STDOUT, start_new_session=True
            )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for number in (signal.SIGINT, signal.SIGKILL):
            try:
                os.killpg(self._process.pid, number)
                self._process.wait(_END)
            except (ProcessLookupError, subprocess.TimeoutExpired):
                continue

    @property
    def said(self) -> str:
        """Output so far."""
        return self._log.read_text("utf-8", "replace")

    def trouble(self, expected: str, *, ends: bool) -> str:
        """Wait for the text, and for a line that ends for its end; empty where both are as expected."""
        deadline = time.monotonic() + _LONG
        while time.monotonic() < deadline:
            code = self._process.poll()
            printed = re.search(expected, self.said) is not None
            if code is not None:
                return "" if printed and ends and code == 0 else f"ended with exit code {code}:\n{self.said}"
            if printed and not ends:
                return ""
            time.sleep(0.2)
        return f"nothing of {expected!r} in {_LONG:g} s:\n{self.said}"


def help_of(line: str) -> str:
    """Command that prints the help of a line which cannot run here."""
    words = line.split()
    return (
        f"{line} --show-args" if words[1] == "launch" else f"{' '.join(words[: 4 if words[1] == 'run' else 3])} --help"
    )


def goes_on(line: str) -> bool:
    """True for a line that does not end by itself."""
    words = line.split()
    return words[1] in {"run", "launch"} or words[1:3] == ["topic", "echo"] or "-r" in words


def main() -> int:
    """Run the lines; 1 if one does not print what it must."""
    if shutil.which("ros2") is None:
        print("skipped: no ros2 on PATH, and the lines are for its tools; source a ROS 2 Jazzy and this workspace")
        return 0
    domain, failed = int(os.environ.get("ROS_DOMAIN_ID", "0")), 0
    with tempfile.TemporaryDirectory() as name, ExitStack() as beside:
        folder = Path(name)

        def check(line: str, command: str, expected: str, *, ends: bool) -> None:
            nonlocal failed
            with Running(command, folder, domain) as running:
                trouble = running.trouble(expected, ends=ends)
            failed += bool(trouble)
            print(f"{'failed' if trouble else 'ok'}: {line}{trouble and chr(10)}{trouble}", flush=True)

        for line in NEEDS:
            check(line, help_of(line), "usage: |Arguments", ends=True)
        starters = [line for line in PRINTS if line.split()[1] in {"run", "launch", "security"}]
        for line in starters:
            check(line, line, PRINTS[line], ends=not goes_on(line))
        for line, expected in BESIDE.items():
            if trouble := beside.enter_context(Running(line, folder, domain)).trouble(expected, ends=False):
                sys.exit(f"failed: {line}\n{trouble}")
        for line in (line for line in PRINTS if line not in starters):
            check(line, line, PRINTS[line], ends=not goes_on(line))
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
