# SPDX-License-Identifier: Apache-2.0
"""Messages of any type with odd contents: empty, huge, not finite, escape sequences, names that nodes know."""

import math
import re

import numpy as np

NUMBERS = (0.0, -0.0, 1.0, -1.0, 2.5, 40.0, 12.566, 1e-300, 1e9, -1e9, 1e308, math.nan, math.inf, -math.inf)
TEXTS = ("", "bit", "top_drive", "bit_axial", "mark_2/x", "mark_2/y", "whirl", "hole", "\x1b[31mred\u202e", "é" * 40,
         "x" * 5000, "../../etc", "{", "0", "40 N", "name: [", "true", "rig_driver", "\n\n")  # fmt: skip
WHOLE = (0, 1, -1, 2, 7, 127, 2**31 - 1, -(2**31), 2**32 - 1, 999_999_999)
_INTEGER = re.compile(r"(u?)int(\d+)$")
_LIST = re.compile(r"(?:sequence<(.+?)(?:, \d+)?>|(.+)\[(\d+)\])$")
_LONGEST = 6


class Oddities:
    """Draws of values and messages from a seeded generator."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def one_of(self, values):
        """One of some values, as it is."""
        return values[int(self._rng.integers(len(values)))]

    def message(self, kind):
        """A message of a class of rclpy with a random value in each field, or with its defaults."""
        message = kind()
        if self._rng.random() < 0.1:
            return message
        for name, field in kind.get_fields_and_field_types().items():
            setattr(message, name, self._value(field, getattr(message, name)))
        return message

    def _value(self, field, present):
        if found := _LIST.match(field):
            inner = found[1] or found[2]
            count = int(found[3] or self._rng.integers(_LONGEST))
            if inner in {"octet", "byte", "uint8"}:
                return [self.one_of((b"\0", b"\xff") if inner != "uint8" else (0, 255)) for _ in range(count)]
            example = present[0] if len(present) and "/" in inner else None
            return [self._value(inner, example if example is not None else _new(inner)) for _ in range(count)]
        if "/" in field:
            return self.message(type(present))
        if field.startswith(("string", "wstring")):
            return self.one_of(TEXTS)
        if field in {"double", "float"}:
            value = self.one_of(NUMBERS)
            return value if field == "double" or not 3e38 < abs(value) < math.inf else 1.0
        if field == "boolean":
            return bool(self._rng.integers(2))
        if field in {"octet", "byte"}:
            return self.one_of((b"\0", b"\x01", b"\xff"))
        if found := _INTEGER.match(field):
            bits = int(found[2])
            low, high = (0, 2**bits - 1) if found[1] else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
            return min(max(self.one_of(WHOLE), low), high)
        raise AssertionError(f"expected a type of ROS, found {field}")


def _new(inner):
    """An empty message of a type such as geometry_msgs/Pose; None for a type that is no message."""
    if "/" not in inner:
        return None
    package, name = inner.split("/")
    return getattr(__import__(f"{package}.msg", fromlist=["msg"]), name)()
