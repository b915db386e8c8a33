# SPDX-License-Identifier: Apache-2.0
"""Set-points made from others: no value of them is forgotten, wherever that is done."""

import math

import pytest

from drill_twin.scene.set_points import Command
from drill_twin.scene.set_points.command import QUANTITIES

NAMES = Command._fields


def _only(name: str, value: float) -> Command:
    """Set-points of which one alone is not zero."""
    return Command(**{each: value if each == name else 0.0 for each in NAMES})


def test_the_values_are_all_fields_in_their_order():
    command = Command(*range(len(NAMES)))
    assert command == tuple(command.array())


@pytest.mark.parametrize("name", NAMES)
def test_each_value_is_checked_completed_and_moved(name):
    missing, wanted = _only(name, math.nan), _only(name, 8.0)
    assert not missing.is_finite()
    assert missing.completed(wanted) == wanted
    rest = _only(name, 0.0)
    assert rest.mixed(wanted, 0.25) == _only(name, 2.0)
    (quantity,) = (names for names in QUANTITIES.values() if name in names)
    assert wanted.part(quantity).completed(missing) == wanted
