# SPDX-License-Identifier: Apache-2.0
"""SIGINT and SIGTERM at random times of commands and nodes: one line at most, and the exit code of the signal.

`DRILL_TWIN_SIGNALS=1000 pytest test/cli/test_interrupts.py -m long` takes more of them.
"""

import os
import random
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2]
LONG = int(os.environ.get("DRILL_TWIN_SIGNALS", "15"))
CLI = ("-m", "drill_twin.cli")
COMMANDS = (
    (*CLI, "scene", "list", "--json"),
    (*CLI, "scene", "check", "pa6_bench"),
    (*CLI, "run", "pa6_bench", "--duration", "500 s"),
)
WITH_WORKERS = (*CLI, "effects", "pa6_bench", "--duration", "100 s", "--workers", "2")
NODES = tuple(("-m", "drill_twin.ros", name) for name in ("simulator", "rig_driver", "analyzer", "recorder"))


def environment():
    """The environment of a child that finds this source tree."""
    path = os.pathsep.join(filter(None, (str(PACKAGE), os.environ.get("PYTHONPATH"))))
    return dict(os.environ, PYTHONPATH=path, PYTHONUNBUFFERED="1")


def catches(pid, number):
    """Whether a process has a handler for a signal; before, Python itself starts."""
    try:
        status = Path(f"/proc/{pid}/status").read_text("utf-8")
    except OSError:
        return False
    return bool(int(status.partition("SigCgt:")[2].split()[0], 16) >> (number - 1) & 1)


def end_at(command, number, delay, folder):
    """Exit code, output and seconds to the end of a process that gets a signal after a delay [s]."""
    given = environment() | {"ROS_DOMAIN_ID": str(1 + os.getpid() % 101), "ROS_LOG_DIR": str(folder)}
    with (folder / "said").open("w+", encoding="utf-8") as said:
        child = subprocess.Popen(
            [sys.executable, *command], stdout=subprocess.DEVNULL, stderr=said, env=given, cwd=folder
        )
        try:
            while child.poll() is None and not catches(child.pid, signal.SIGTERM):
                time.sleep(0.002)
            time.sleep(delay)
            child.send_signal(number)
            code = child.wait(60.0)
        finally:
            child.kill()
            child.wait()
        said.seek(0)
        return code, said.read()


def sweep(seed, count, longest, folder, choices=COMMANDS):
    """End random commands at random times; the outcome of each must be that of an orderly end."""
    chance = random.Random(seed)
    for turn in range(count):
        command, number = chance.choice(choices), chance.choice((signal.SIGINT, signal.SIGTERM))
        delay, place = chance.uniform(0.0, longest), folder / str(turn)
        place.mkdir()
        code, said = end_at(command, number, delay, place)
        case = f"{' '.join(command)}, {number.name} after {delay:.3f} s: exit code {code}\n{said}"
        node = command in NODES
        assert code in ({0} if node else {128 + number, 0}), case
        lines = [line for line in said.splitlines() if not (node and line.startswith("["))]  # those of the node's log
        assert "Traceback" not in said, case
        assert "gnored" not in said, case
        if code and "the bag is whole" not in said:
            assert lines[-1].startswith("drill-twin: stopped"), case


def test_a_signal_at_any_time_of_the_start_gives_one_line(tmp_path):
    sweep(seed=14, count=3, longest=1.0, folder=tmp_path)


@pytest.mark.long
def test_many_signals_at_any_time(tmp_path):
    nodes = NODES if find_spec("rclpy") else ()
    sweep(seed=2, count=LONG, longest=3.0, folder=tmp_path, choices=(*COMMANDS, WITH_WORKERS, *nodes))


def test_a_signal_before_the_first_import_of_a_command_ends_it(tmp_path):
    """The signal comes within the import of the command line, which would swallow or print an exception."""
    (tmp_path / "typer.py").write_text(
        "import os, signal, time\nos.kill(os.getpid(), signal.SIGINT)\ntime.sleep(9)\n", "utf-8"
    )
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from drill_twin.cli import main; main(['scene', 'list'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False, env=environment()
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "drill-twin: stopped\n")


def test_signals_that_the_parent_ignores_stay_ignored(tmp_path):
    """As under `nohup`, or for a job in the background of a script."""
    code = (
        "import os, signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "from drill_twin.cli import interrupt; interrupt.install(); os.kill(os.getpid(), signal.SIGINT); print('runs')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=environment())
    assert done.stdout == "runs\n"
