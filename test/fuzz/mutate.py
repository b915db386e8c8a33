# SPDX-License-Identifier: Apache-2.0
"""Damage done to a file: as a bad disk does it, and as a person in an editor does it."""

import re

import numpy as np

NUMBER = re.compile(rb"(?<![\w.])-?\d+(?:\.\d*)?(?:e[-+]?\d+)?")
ODD = (
    b"nan", b".nan", b".inf", b"-1", b"0", b"-0.0", b"1e400", b"1e-320", b"1e308", b"99999999999999999999", b"0x7f",
    b"40 parsec", b"40 N", b"1/0", b"[1, 2]", b"{}", b"null", b"true", b"", b'"', b"'", b"!!python/object:os.system {}",
    b"&a [*a]", b"*a", b"\x00", b"\xff\xfe", b"\xe2\x80\xae", b"1" * 400, b"[" * 200, b"- " * 200, b"a: " * 60,
)  # fmt: skip
EXTREME = tuple(value.to_bytes(8, "little") for value in (0, 1, 2**31 - 1, 2**32 - 1, 2**40, 2**63 - 1, 2**64 - 1))


def mutated(data: bytes, random: np.random.Generator, *, text: bool) -> bytes:
    """The data with one to four things wrong with it."""
    for _ in range(int(random.integers(1, 5))):
        kinds = _BYTES + (_TEXT if text else ()) * 2
        data = kinds[int(random.integers(len(kinds)))](data, random)
    return data


def _place(data, random):
    return int(random.integers(len(data) + 1))


def _piece(data, random, longest=64):
    start = _place(data, random)
    return start, min(start + int(random.integers(1, longest)), len(data))


def _flip(data, random):
    changed = bytearray(data)
    for _ in range(int(random.integers(1, 8))):
        if changed:
            changed[int(random.integers(len(changed)))] ^= 1 << int(random.integers(8))
    return bytes(changed)


def _cut_off(data, random):
    return data[: _place(data, random)]


def _leave_out(data, random):
    start, end = _piece(data, random)
    return data[:start] + data[end:]


def _repeat(data, random):
    start, end = _piece(data, random)
    return data[:end] + data[start:end] * int(random.integers(1, 20)) + data[end:]


def _insert(data, random):
    start = _place(data, random)
    return data[:start] + random.bytes(int(random.integers(1, 32))) + data[start:]


def _overwrite(data, random):
    start, value = _place(data, random), EXTREME[int(random.integers(len(EXTREME)))][: int(random.choice((1, 2, 4, 8)))]
    return data[:start] + value + data[start + len(value) :]


def _odd_number(data, random):
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    place = found[int(random.integers(len(found)))]
    return data[: place.start()] + ODD[int(random.integers(len(ODD)))] + data[place.end() :]


def _odd_lines(data, random):
    lines = data.split(b"\n")
    k, other = (int(random.integers(len(lines))) for _ in range(2))
    what = int(random.integers(5))
    if what == 0:
        del lines[k]
    elif what == 1:
        lines.insert(other, lines[k])
    elif what == 2:
        lines[k] = b" " * int(random.integers(1, 5)) + lines[k]
    elif what == 3:
        lines[k] = lines[k].lstrip()
    else:
        lines[k] += ODD[int(random.integers(len(ODD)))]
    return b"\n".join(lines)


_BYTES = (_flip, _cut_off, _leave_out, _repeat, _insert, _overwrite)
_TEXT = (_odd_number, _odd_lines)
