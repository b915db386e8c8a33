# SPDX-License-Identifier: Apache-2.0
"""Companion packages, and entry points of installed packages.

What a companion brings (commands, nodes, functions of the API) is found by entry points, as with any other package.
The table here has the names of the companions that belong to drill_twin, so that the command line can say what to
install for a name of theirs.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import EntryPoint, entry_points

from drill_twin.core.errors import ArgumentError


@dataclass(frozen=True)
class Companion:
    """A package beside the core, of the same version."""

    name: str
    """Name of the package, and of its distribution."""
    purpose: str
    """Its purpose, in a few words."""
    commands: Mapping[str, str] = field(default_factory=dict)
    """Commands by their whole name, as `ros keys`, with the panel of the help that they stand in."""
    nodes: Mapping[str, str] = field(default_factory=dict)
    """Nodes and programs by name, with the flag that asks for each."""
    programs: frozenset[str] = frozenset()
    """Names in `nodes` of programs with threads of their own, which no other process can run as a node."""


COMPANIONS = (
    Companion(
        "drill_twin_rig",
        "rig software by OPC UA and WITS 0, and files of the Drillbotics competition",
        {"ros keys": ""},
        {"gateway": "gateway"},
    ),
    Companion(
        "drill_twin_dashboard",
        "the live page in a browser",
        {"watch": "Runs and records"},
        {"watch": "watch"},
        frozenset({"watch"}),
    ),
    Companion(
        "drill_twin_studies",
        "operating maps with their advice, fits and the estimator",
        dict.fromkeys(("map", "fit", "estimate"), "Questions about a string"),
        {"advisor": "advise", "estimator": "estimate"},
    ),
)


_installed = cache(entry_points)
"""Entry points of all groups: reading them from all installed packages takes 20 ms."""


@cache
def entries(group: str) -> tuple[EntryPoint, ...]:
    """Entry points of a group, by the name of their package and their own."""
    return tuple(sorted(_installed().select(group=group), key=lambda entry: (package_of(entry), entry.name)))


def package_of(entry: EntryPoint) -> str:
    """Name of the package that declares an entry point."""
    return entry.dist.name if entry.dist else entry.value.partition(".")[0]


def entry_of(group: str, name: str) -> EntryPoint | None:
    """Entry point of a name, from the first package that declares the name; None if no package declares it."""
    return next((entry for entry in entries(group) if entry.name == name), None)


def is_installed(package: str) -> bool:
    """True for a companion that has registered commands, perhaps not all of today's."""
    return package in map(package_of, entries("drill_twin.commands"))


def not_installed(wanted: str, package: str) -> ArgumentError:
    """Error on a name whose companion is not installed, or was installed without it.

    Args:
        wanted: What needs it, as the begin of a sentence.
        package: Name of the companion.
    """
    what = next((f" ({one.purpose})" for one in COMPANIONS if one.name == package), "")
    state = "installed without it: make setup (in a clone), or" if is_installed(package) else "which is not installed:"
    return ArgumentError(
        f"{wanted} needs the package {package}{what}, {state} pip install {package}, or pip install 'drill_twin[all]'"
    )
