# SPDX-License-Identifier: Apache-2.0
"""Members of an ensemble: the values in which each differs from the base scene."""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from drill_twin.core.errors import ArgumentError, SceneError
from drill_twin.core.units.registry import si_factor, tidy
from drill_twin.dynamics.twin.dynamics import kernel_of
from drill_twin.scene import Scene, load
from drill_twin.scene.overrides import SHORTHANDS, full_key
from drill_twin.scene.schema import number_at

LARGEST = 1_000_000
"""Largest number of members."""
SEED = "seed"
"""Short for `numerics.seed`."""

Value = float | str
"""Number in SI, or text with a unit."""


@dataclass(frozen=True)
class Member:
    """One member: its values by key, as given."""

    number: int
    values: Mapping[str, Value]

    def __str__(self) -> str:
        """Number and values."""
        return f"member {self.number} ({', '.join(f'{key}={value}' for key, value in self.values.items())})"


@dataclass(frozen=True)
class Members:
    """All members of an ensemble.

    Attributes:
        base: The scene that each member varies.
        vary: Values by key.
        zipped: True if the first values of all keys make a member, then the second values; else each value of a key is
            combined with each value of the other keys.
    """

    base: Scene
    vary: Mapping[str, Sequence[Value]]
    zipped: bool

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of members, along each key where each value is taken with each other."""
        lengths = [len(values) for values in self.vary.values()]
        return (lengths[0],) if self.zipped else tuple(lengths)

    @property
    def told(self) -> str:
        """Number of members, and of the values of each key, in words."""
        values = [f"{len(values)} of {key}" for key, values in self.vary.items()]
        return f"{len(self)} members, {(' with ' if self.zipped else ' x ').join(values)}"

    def __len__(self) -> int:
        """Number of members."""
        return math.prod(self.shape)

    def __iter__(self) -> Iterator[Member]:
        """The members, the last key fastest."""
        columns = self.vary.values()
        rows = zip(*columns, strict=True) if self.zipped else itertools.product(*columns)
        for number, row in enumerate(rows):
            yield Member(number, dict(zip(self.vary, row, strict=True)))

    def numbers(self, key: str) -> list[Value]:
        """Values of a key, texts with a unit as numbers in SI (of `rpm` in rev/min); as given if a text is no number.

        Raises:
            SceneError: The values of a member do not fit.
        """
        place, unit = SHORTHANDS.get(key) or (_key(self.base, key), "")
        found = list(self.vary[key])
        for index, value in enumerate(found):
            if isinstance(value, str):
                number = number_at(self.scene(next(one for one in self if one.values[key] == value)), place)
                if number is None:
                    return list(self.vary[key])
                found[index] = tidy(number / (si_factor(unit)[0] if unit else 1.0))
        return found

    def scene(self, member: Member) -> Scene:
        """Scene of a member.

        Raises:
            SceneError: Its values do not fit; the message begins with the member.
        """
        return scene_of(self.base, member)


def scene_of(base: Scene, member: Member) -> Scene:
    """Scene of a member of a base scene.

    Raises:
        SceneError: A key is not in the scene, or its values do not fit; the message begins with the member.
    """
    overrides = {_key(base, key): value for key, value in member.values.items()}
    try:
        return load.override(base, overrides)
    except SceneError as error:
        raise SceneError(f"{member}: {error}") from error


def _key(base: Scene, key: str) -> str:
    """Key of an override of a scene."""
    if key == SEED:
        return "numerics.seed"
    return key if key in SHORTHANDS else full_key(key, base)


def expand(base: Scene, vary: Mapping[str, Any], *, zipped: bool = False) -> Members:
    """Members for the values of some keys.

    Args:
        base: The scene.
        vary: Sequence of values by key.
        zipped: Take the first values of all keys together, then the second, and so on.

    Raises:
        ArgumentError: No key, no values, values of different number to be zipped, or too many members.
        SceneError: A value does not fit the scene.
    """
    if not vary:
        raise ArgumentError("vary: expected at least one key with its values, found none")
    values = {key: _values(key, given) for key, given in vary.items()}
    lengths = {key: len(found) for key, found in values.items()}
    if zipped and len(set(lengths.values())) > 1:
        found = ", ".join(f"{count} of {key}" for key, count in lengths.items())
        raise ArgumentError(f"vary: expected as many values of each key, to be zipped, found {found}")
    count = max(lengths.values()) if zipped else math.prod(lengths.values())
    if count > LARGEST:
        raise ArgumentError(f"vary: expected at most {LARGEST} members, found {count}; take fewer values of a key")
    members = Members(base, values, zipped)
    _check_alike(members)
    return members


def _values(key: str, given: Any) -> list[Value]:
    """Values of a key as plain numbers and texts."""
    if isinstance(given, str) or not hasattr(given, "__iter__"):
        raise ArgumentError(f"{key}: expected a list of values, found {given!r}; write [{given!r}] for a single one")
    values: list[Value] = [value.item() if isinstance(value, np.generic) else value for value in given]
    if not values:
        raise ArgumentError(f"{key}: expected at least one value, found none")
    for value in values:
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not isinstance(value, str) and not (number and math.isfinite(value)):
            raise ArgumentError(f"{key}: expected finite numbers or texts with a unit, found {value!r}")
    return values


def _check_alike(members: Members) -> None:
    """Build the scene of each value, and check that all share one kernel, their marks and their frames.

    Where the values are combined, each value of a key is checked with the first values of the other keys, so that a
    million members are not built twice. A combination that does not fit is found when its member is run.
    """
    first: tuple[Any, ...] | None = None
    begin = {key: values[0] for key, values in members.vary.items()}
    for member in members:
        if not members.zipped and sum(value != begin[key] for key, value in member.values.items()) > 1:
            continue
        scene = members.scene(member)
        marks = [mark.name for mark in scene.string.marks]
        found = {"effects and formulation": kernel_of(scene), "marks": marks, "frame rate": scene.numerics.frame_rate}
        if first is None:
            first = (member, found)
        for name, value in found.items():
            if value != first[1][name]:
                raise ArgumentError(
                    f"vary: expected members with the same {name}, found {member} with others than {first[0]}; "
                    "run an ensemble for each"
                )
