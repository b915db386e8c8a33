# SPDX-License-Identifier: Apache-2.0
"""Licences of the dependencies, from the metadata of the installed distributions; needs `make setup-test`."""

import contextlib
import re
import runpy
import sys
from collections import Counter
from importlib import metadata
from pathlib import Path
from typing import Any
from unittest import mock
from xml.etree import ElementTree as ET

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from _printed.markdown import code, table

ROOT = Path(__file__).parents[2]
EXTRAS = ("", "xarray", "las", "opcua", "dask", "foxglove", "ros")
"""Extras whose distributions are listed after the distributions always needed; each stands where it is needed first."""


def licences() -> str:
    """Table of licences and distributions, direct and indirect, for drill_twin and each extra."""
    given = _setup_arguments()
    seen: set[str] = set()
    rows = []
    for extra in EXTRAS:
        names = _closure(given["extras_require"][extra] if extra else given["install_requires"], seen)
        by_licence: dict[str, list[str]] = {}
        for name in sorted(names):
            if not name.startswith("ros-"):  # their metadata has none, their package.xml has
                by_licence.setdefault(_licence(name), []).append(code(name))
        needed_by = f"extra {code(extra)}" if extra else "drill_twin"
        rows += [(needed_by, licence, ", ".join(found)) for licence, found in sorted(by_licence.items())]
    return table(("needed by", "licence", "distributions"), [*rows, *_ros_rows()])


def _setup_arguments() -> dict[str, Any]:
    with contextlib.chdir(ROOT), mock.patch("setuptools.setup") as setup:
        runpy.run_path(str(ROOT / "setup.py"))
    return dict(setup.call_args.kwargs)


def _closure(lines: list[str], seen: set[str], extras: frozenset[str] = frozenset({""})) -> set[str]:
    """Names of the distributions that requirements ask for, directly or through each other, without the seen names."""
    found: set[str] = set()
    for line in lines:
        one = Requirement(line)
        name = canonicalize_name(one.name)
        if name in seen or (one.marker and not any(one.marker.evaluate({"extra": extra}) for extra in extras)):
            continue
        seen.add(name)
        found |= {name, *_closure(metadata.requires(name) or [], seen, frozenset({"", *one.extras}))}
    return found


def _licence(name: str) -> str:
    """Expression, classifiers or short name of a distribution, the first that it states."""
    stated = metadata.metadata(name).json
    lines = [line.rpartition(" :: ")[2] for line in stated.get("classifier", []) if "License ::" in line]
    said = stated.get("license_expression") or ", ".join(lines) or stated.get("license") or "not stated"
    return re.sub(r" \(.*\)$", "", str(said))


def _ros_rows() -> list[tuple[str, str, str]]:
    """Numbers of ROS packages by licence, from the package.xml that each wheel brings."""
    found = Counter(
        ", ".join(sorted({(tag.text or "").strip() for tag in ET.parse(file).iter("license")}))  # noqa: S314
        for file in sorted(Path(sys.prefix, "share").glob("*/package.xml"))
        if file.parent.name != "drill_twin"
    )
    return [("extra `ros`", licence, f"ROS packages: {number}") for licence, number in sorted(found.items())]
