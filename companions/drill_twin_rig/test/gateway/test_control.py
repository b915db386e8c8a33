# SPDX-License-Identifier: Apache-2.0
"""Control by grant and heartbeat, without network: who may what, and when it ends."""

import math

import pytest

from drill_twin_rig.gateway.control import HEARTBEAT, REQUEST, Control, Permission, User
from drill_twin_rig.gateway.signals import CommandTarget

WOB = CommandTarget("weight_on_bit", "kN", 1000.0, "WOBTarget", 0.0, 100.0)


@pytest.fixture
def now():
    return [0.0]


@pytest.fixture
def limits():
    return {}


@pytest.fixture
def control(now, limits):
    return Control([WOB], 2.0, lambda: None, limits, lambda: now[0])


def _holder(control, name="one"):
    user = User(name, may_command=True)
    assert control.refusal(user, REQUEST, True) is None
    control.write(user, REQUEST, True)
    assert control.grant()
    return user


def test_a_target_needs_a_known_user_and_a_grant(control):
    user = User("one", may_command=True)
    assert control.refusal(User(), REQUEST, True).text == "an anonymous user may not command"
    assert "no control" in control.refusal(user, "WOBTarget", 1.0).text
    assert not control.grant()
    user = _holder(control)
    assert control.refusal(user, "WOBTarget", 1.0) is None
    control.write(user, "WOBTarget", 1.0)
    assert control.values == {"weight_on_bit": 1000.0}
    assert control.holder == "one"


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0, 101.0, None, "5", True, [1.0]])
def test_a_value_that_is_no_set_point_is_refused(control, value):
    user = _holder(control)
    assert control.refusal(user, "WOBTarget", value).of_value


def test_without_limits_of_a_file_those_of_the_simulator_hold(now, limits):
    """1e308 was answered Good once, and published."""
    open_ended = CommandTarget("weight_on_bit", "kN", 1000.0, "WOBTarget", 0.0, math.inf)
    control = Control([open_ended], 2.0, lambda: None, limits, lambda: now[0])
    user = _holder(control)
    assert control.refusal(user, "WOBTarget", 1e308).text.endswith("or low and high in the file, found none so far")
    limits["weight_on_bit"] = (-1.0, 400.0)
    assert control.refusal(user, "WOBTarget", 1e308).text == "WOBTarget: expected 0 to 0.4 kN, found 1e+308 kN"
    assert control.refusal(user, "WOBTarget", 0.41).of_value
    assert control.refusal(user, "WOBTarget", -0.001).of_value
    assert control.refusal(user, "WOBTarget", 0.4) is None


def test_a_limit_of_the_file_stays_below_the_simulator_s(control, limits):
    assert control.is_unsure("WOBTarget")
    limits["weight_on_bit"] = (-1e9, 1e9)
    assert not control.is_unsure("WOBTarget")
    assert control.refusal(_holder(control), "WOBTarget", 101.0).text == "WOBTarget: expected 0 to 100 kN, found 101 kN"


def test_an_endless_text_is_not_repeated(control):
    assert len(control.refusal(_holder(control), "WOBTarget", "x" * 1_000_000).text) < 200


def test_only_a_heartbeat_that_changes_keeps_control(control, now):
    user = _holder(control)
    for number, time in enumerate((1.5, 3.0, 4.5)):
        now[0] = time
        control.write(user, HEARTBEAT, number)
        assert not control.check_heartbeat()
    for time in (5.0, 6.4):
        now[0] = time
        control.write(user, HEARTBEAT, 2)
        assert not control.check_heartbeat()
    now[0] = 6.6
    assert control.check_heartbeat()
    assert not control.check_heartbeat()
    assert control.permission is Permission.INVALID
    assert control.lost == "no heartbeat of one for 2 s"
    assert "no control" in control.refusal(user, "WOBTarget", 1.0).text


def test_one_holder_at_a_time_and_another_cannot_end_it(control):
    first, second = _holder(control), User("one", may_command=True)
    assert control.refusal(second, REQUEST, True).text == "one has control or requests it"
    control.write(second, REQUEST, False)
    assert control.holder == "one"
    control.write(first, REQUEST, False)
    assert control.permission is Permission.UNSET
    assert not control.lost


def test_a_request_without_heartbeat_is_forgotten(control, now):
    control.write(User("one", may_command=True), REQUEST, True)
    now[0] = 2.1
    assert not control.check_heartbeat()
    assert control.user is None
    assert not control.grant()
