# SPDX-License-Identifier: Apache-2.0
"""Checks of this machine: Python, packages, ROS, cache of compiled kernels, clock; works without ROS."""

import ctypes
import importlib
import os
import platform
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from drill_twin.core import __version__
from drill_twin.core.errors import DrillTwinError
from drill_twin.core.process import child_environment

INSTALLED, ROS, MACHINE = "installed", "ROS 2", "machine"
DISTRO = "jazzy"
_SHARED_MEMORY = Path("/dev/shm")  # noqa: S108  Fast DDS puts its segments here
_LEAST_SHARED_MEMORY = 64 * 2**20  # bytes
_PROBE_TIME = 60.0  # s
_TIME_ERROR = 5  # of adjtimex(2): the clock is not synchronised
_TIMEX_BYTES = 512  # more than struct timex has on any machine


class Verdict(StrEnum):
    """Verdicts, by weight: a problem makes the exit code 1."""

    OK = "ok"
    NOTE = "note"
    PROBLEM = "problem"


@dataclass(frozen=True)
class Check:
    """One check: what was looked at, what was found, and what to do."""

    section: str
    """Heading under which it is printed."""
    name: str
    found: str
    verdict: Verdict = Verdict.OK
    remedy: str = ""
    """Remedy; empty where there is nothing."""


def judged(section: str, name: str, found: str, remedy: str, otherwise: Verdict = Verdict.PROBLEM) -> Check:
    """Check that is well unless there is a remedy."""
    return Check(section, name, found, otherwise if remedy else Verdict.OK, remedy)


def installation() -> Iterator[Check]:
    """Checks of the packages and of the machine."""
    yield Check(INSTALLED, "drill_twin", f"{__version__} in {Path(__file__).parents[2]}")
    yield _python()
    for name in ("numpy", "numba", "scipy", "rosbags", "mcap", "matplotlib"):
        yield _package(name)
    yield from _kernel_cache()
    yield _clock()
    yield _shared_memory()


def ros_present() -> bool:
    """True where rclpy is installed; whether it can be loaded is a check of its own."""
    return find_spec("rclpy") is not None


def ros_installation() -> Iterator[Check]:
    """Checks of ROS and of the variables that decide who finds whom."""
    distro = os.environ.get("ROS_DISTRO", "")
    if not ros_present():
        yield Check(
            ROS,
            "rclpy",
            "not installed: simulation, analysis, reports and the page of a bag work; nodes, replay and load do not",
            Verdict.NOTE,
            "for the nodes: source /opt/ros/jazzy/setup.bash, or pip install 'drill_twin[ros]' (clone: make setup)",
        )
        return
    middleware, error = _middleware()
    remedy = f"source /opt/ros/{DISTRO}/setup.bash; nodes of different distributions need not understand each other"
    found = distro or f"{DISTRO}, not sourced"
    yield judged(ROS, "distribution", found, "" if distro in {"", DISTRO} else remedy)
    if error:  # loading it here would end this process
        yield _broken(error)
        return
    yield _rclpy()
    remedy = "all nodes need the same; the discovery profile and the tests of this package are for rmw_fastrtps_cpp"
    yield judged(ROS, "middleware", middleware, "" if middleware == "rmw_fastrtps_cpp" else remedy, Verdict.NOTE)
    for package, purpose in (("tf2_msgs", "tf"), ("simulation_interfaces", "standard services")):
        there = find_spec(package) is not None
        yield Check(ROS, package, "installed" if there else f"not installed: the simulator has no {purpose}")
    yield from _domain()
    yield from _discovery()


def _python() -> Check:
    tested = platform.python_version_tuple()[:2] in {("3", "11"), ("3", "12")}
    remedy = "" if tested else "tested with 3.11 and 3.12 only"
    return judged(INSTALLED, "python", f"{platform.python_version()}, {sys.executable}", remedy, Verdict.NOTE)


def _package(name: str) -> Check:
    try:
        importlib.import_module(name)
        return Check(INSTALLED, name, version(name))
    except PackageNotFoundError:
        return Check(INSTALLED, name, "of unknown version")
    except ImportError as error:
        remedy = f"run make setup, or pip install {name} into {sys.prefix}"
        if name == "numba" and "NumPy" in str(error):
            remedy = 'pip install "numpy<2" beside a sourced ROS 2 Jazzy (docs/install.md)'
        return Check(INSTALLED, name, f"cannot be loaded: {error}", Verdict.PROBLEM, remedy)


def _kernel_cache() -> Iterator[Check]:
    try:
        from drill_twin.core.files.kept_files import permanent_folder

        folder = permanent_folder()
    except (ImportError, DrillTwinError) as error:
        yield Check(INSTALLED, "compiled kernels", str(error), Verdict.PROBLEM, "name another DRILL_TWIN_CACHE")
        return
    if folder is None:
        yield Check(
            INSTALLED,
            "compiled kernels",
            "no folder of your own can be written to: each process compiles for a minute",
            Verdict.PROBLEM,
            "make ~/.cache/drill_twin your own (mode 0700), or name a folder with DRILL_TWIN_CACHE",
        )
        return
    files = [file for file in folder.rglob("*") if file.is_file()]
    size = sum(file.stat().st_size for file in files) / 1e6
    yield Check(INSTALLED, "compiled kernels", f"{folder}: {len(files)} files, {size:.0f} MB")
    free = shutil.disk_usage(folder).free
    if free < 1e9:
        yield Check(INSTALLED, "disk", f"{free / 1e6:.0f} MB free at {folder}", Verdict.PROBLEM, "free a gigabyte")


def _clock() -> Check:
    """The clock matters where nodes run on several machines: diagnostics and bags have its stamps."""
    if sys.platform != "linux":
        return Check(MACHINE, "clock", "synchronisation unknown")
    if ctypes.CDLL(None).adjtimex(ctypes.create_string_buffer(_TIMEX_BYTES)) != _TIME_ERROR:
        return Check(MACHINE, "clock", "synchronised")
    shared = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").upper() in {"SUBNET", "SYSTEM_DEFAULT"}
    remedy = "install and start chrony or systemd-timesyncd on each machine" if shared else ""
    return Check(MACHINE, "clock", "not synchronised", Verdict.PROBLEM if shared else Verdict.NOTE, remedy)


def _shared_memory() -> Check:
    if not _SHARED_MEMORY.is_dir():
        return Check(MACHINE, "shared memory", "none: DDS uses the network interface of this host", Verdict.NOTE)
    free = shutil.disk_usage(_SHARED_MEMORY).free
    left = sum(1 for file in _SHARED_MEMORY.iterdir() if file.name.startswith("fastrtps"))
    found = f"{free / 2**20:.0f} MB free, {left} files of Fast DDS"
    remedy = "run fastdds shm clean, or export FASTDDS_BUILTIN_TRANSPORTS=UDPv4"
    return judged(MACHINE, "shared memory", found, remedy if free < _LEAST_SHARED_MEMORY else "")


def _middleware() -> tuple[str, str]:
    """Name of the middleware, and the error with which rclpy ends; in a child, since it ends the whole process."""
    code = "from rclpy.utilities import get_rmw_implementation_identifier as name; print(name())"
    try:
        done = subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            timeout=_PROBE_TIME,
            check=False,
            env=child_environment(),
        )
    except subprocess.TimeoutExpired:
        return "", f"no answer within {_PROBE_TIME:g} s"
    if done.returncode == 0:
        return done.stdout.strip(), ""
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    said = lines[-1].strip() if lines else f"exit code {done.returncode}"
    return "", re.sub(r"^(\[[^]]*\] ?)+: |, at \S+:\d+$", "", said)


def _broken(error: str) -> Check:
    if wanted := os.environ.get("RMW_IMPLEMENTATION", ""):
        remedy = f"install ros-{DISTRO}-{wanted.replace('_', '-')}, or unset RMW_IMPLEMENTATION (it is {wanted})"
    else:
        remedy = "start a new shell; source one ROS only, and no virtual environment with ROS wheels beside it"
    return Check(ROS, "rclpy", f"cannot be loaded: {error}", Verdict.PROBLEM, remedy)


def _rclpy() -> Check:
    rclpy = importlib.import_module("rclpy")
    place = Path(rclpy.__file__ or "").parent
    try:
        found = f"{version('rclpy')}, {place}"
    except PackageNotFoundError:
        found = str(place)
    if "site-packages" in place.parts and "/opt/ros" in os.environ.get("AMENT_PREFIX_PATH", ""):
        remedy = "use the rclpy of /opt/ros: rm -rf .venv, then make setup in the shell that has sourced ROS"
        return Check(ROS, "rclpy", f"{found}, of the wheels, beside a sourced ROS", Verdict.PROBLEM, remedy)
    return Check(ROS, "rclpy", found)


def _domain() -> Iterator[Check]:
    from drill_twin.ros.deployment import HIGHEST_DOMAIN, domain_of_environment

    try:
        domain = domain_of_environment()
    except DrillTwinError as error:
        yield Check(ROS, "domain", str(error), Verdict.PROBLEM, "export ROS_DOMAIN_ID=0")
        return
    high = f"choose a domain up to {HIGHEST_DOMAIN}: other programs may have the ports"
    yield judged(ROS, "domain", str(domain or 0), high if (domain or 0) > HIGHEST_DOMAIN else "", Verdict.NOTE)


def _discovery() -> Iterator[Check]:
    given = os.environ
    if given.get("ROS_LOCALHOST_ONLY") == "1":
        yield Check(
            ROS,
            "discovery",
            "ROS_LOCALHOST_ONLY=1 goes before ROS_AUTOMATIC_DISCOVERY_RANGE",
            Verdict.NOTE,
            "unset ROS_LOCALHOST_ONLY; it is deprecated",
        )
    else:
        server = f", server {given['ROS_DISCOVERY_SERVER']}" if given.get("ROS_DISCOVERY_SERVER") else ""
        yield Check(ROS, "discovery", given.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST (our default)") + server)
    for name in ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE"):
        if (file := given.get(name)) and not Path(file).is_file():
            yield Check(ROS, "DDS profile", f"{name}={file} is no file", Verdict.PROBLEM, f"unset {name}")
    if given.get("ROS_SECURITY_STRATEGY", "").lower() == "enforce":
        from drill_twin.ros.deployment import refuse_unsecured

        try:
            refuse_unsecured()
            yield Check(ROS, "security", "enforced")
        except DrillTwinError as error:
            yield Check(ROS, "security", str(error), Verdict.PROBLEM, "see docs on security")
