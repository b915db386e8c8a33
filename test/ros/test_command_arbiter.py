# SPDX-License-Identifier: Apache-2.0
"""Command arbiter: refusals, priority of sources, behaviour without commands."""

import math
from types import SimpleNamespace

import pytest

from drill_twin.core.errors import ParameterError
from drill_twin.ros.simulator.command_arbiter import CommandArbiter
from drill_twin.ros.simulator.command_limits import SIMULATED, CommandError, CommandStamps, limits_for
from drill_twin.scene import load_scene
from drill_twin.scene.set_points import Command
from drill_twin_evidence.verify.statics.block import rig

TURN = 2.0 * math.pi
NONE = math.nan


class Clock:
    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def make(clock):
    """An arbiter of a simulator with these parameters, whose simulated time is 0."""

    def arbiter(scene="pa6_bench", **parameters):
        settings = SimpleNamespace(
            command_timeout=1.0, on_silence="hold", safe_weight_on_bit=0.0, safe_speed=0.0, safe_ramp_time=5.0,
            max_weight_on_bit=400.0, max_speed=20.0 * TURN, negative_commands=False,
        )  # fmt: skip
        vars(settings).update(parameters)
        scene = load_scene(scene) if isinstance(scene, str) else scene
        return CommandArbiter(scene, settings, CommandStamps("realtime", 10_000_000, lambda: 0), clock=clock)

    return arbiter


@pytest.fixture
def arbiter(make):
    return make()


@pytest.mark.parametrize(
    ("command", "kind"),
    [
        (Command(NONE, NONE, NONE), "not_finite"),
        (Command(40.0, math.inf), "not_finite"),
        (Command(-math.inf, 6.0), "not_finite"),
        (Command(-1.0, 6.0), "out_of_range"),
        (Command(40.0, -6.0), "out_of_range"),
        (Command(1e9, 6.0), "out_of_range"),
        (Command(40.0, 1e9), "out_of_range"),
    ],
)
def test_a_command_that_cannot_be_meant_is_refused_whole(arbiter, command, kind):
    good = Command(40.0, 12.0)
    assert arbiter.command(1, good) == ""
    assert arbiter.command(2, command) == kind
    assert arbiter.kept == good
    assert arbiter.set_point(0.01) == good
    assert arbiter.refused == {kind: 1}
    assert "expected" in arbiter.last_refusal
    stamps = {quantity.last_stamp for quantity in arbiter.quantities if quantity.is_in(command)}
    assert stamps <= {2}  # it came, though refused: lockstep goes on


@pytest.mark.parametrize(
    ("block", "reason"),
    [
        (None, "the scene has no `rig.block`"),
        ({"auto_driller": {"rate": 0.02}}, "the auto-driller moves it"),
        ({"value": -0.01}, ""),
    ],
)
def test_a_speed_of_the_block_that_nothing_follows_is_refused_by_itself(make, block, reason):
    scene = load_scene("pa6_bench") if block is None else rig({"weight_on_bit": {"at": "block"}, "block": block})
    arbiter = make(scene)
    arbiter.command(1, Command(40.0, 6.0))
    assert not arbiter.refused
    arbiter.command(2, Command(30.0, 6.0, 0.1))
    if not reason:
        assert arbiter.kept == Command(30.0, 6.0, 0.1)
        return
    assert arbiter.kept == Command(30.0, 6.0)
    assert arbiter.refused == {"block": 1}
    assert arbiter.refused_recently  # a warning in diagnostics and log
    expected = f"speed of the block: expected none, since {reason}, found 0.1 m/s; the other set-points are followed"
    assert arbiter.last_refusal == expected


def test_silence_ramps_every_set_point(make, clock):
    """The block comes to rest with the others, and not at once."""
    scene = rig({"weight_on_bit": {"at": "block"}, "block": {"value": -0.01}})
    arbiter = make(scene, on_silence="ramp", safe_weight_on_bit=10.0, safe_speed=1.0, safe_ramp_time=4.0)
    arbiter.command(1, Command(50.0, 9.0, -0.008))
    assert arbiter.set_point(1.0) == arbiter.kept == arbiter.kept
    clock.now += 1.5
    assert arbiter.set_point(1.0) == pytest.approx((40.0, 7.0, -0.006))
    assert arbiter.kept == arbiter.applied  # a checkpoint does not take up again what was lost
    assert [arbiter.set_point(1.0) for _ in range(4)][-1] == Command(10.0, 1.0)


def test_limits_include_their_ends(arbiter):
    for command in (Command(0.0, 0.0), Command(400.0, 20.0 * TURN)):
        arbiter.command(1, command)
        assert arbiter.kept == command


def test_single_values_change_one_set_point_each(arbiter):
    arbiter.weight_on_bit(30.0)
    arbiter.speed(2.0)
    assert arbiter.kept == Command(30.0, 2.0 * TURN)
    arbiter.speed(math.nan)
    assert arbiter.kept == Command(30.0, 2.0 * TURN)


DRIVER, OTHER = "/rig_driver", "/other"


@pytest.mark.parametrize(("first", "second"), [(DRIVER, OTHER), (DRIVER, ""), ("", OTHER)])
def test_the_first_commander_keeps_the_rig_until_it_is_silent(arbiter, clock, first, second):
    for stamp in range(50):
        arbiter.command(stamp, Command(40.0, 12.0), first)
        arbiter.command(1000 + stamp, Command(77.0, 6.0), second)
        clock.now += 0.01
    assert arbiter.kept == Command(40.0, 12.0)
    assert arbiter.refused == {"other_source": 50}
    assert arbiter.last_refusal == (
        f"expected commands of {first or 'anonymous'} alone, which has the rig until it is silent for 1 s, "
        f"found a command of {second or 'anonymous'}; stop one of the two"
    )
    assert {quantity.last_stamp for quantity in arbiter.quantities} == {49}  # another's sets no frame free
    assert arbiter.commander == (first or "anonymous")
    clock.now += 1.1
    assert arbiter.commander == ""
    arbiter.command(60, Command(77.0, 6.0), second)
    assert arbiter.kept == Command(77.0, 6.0)
    assert arbiter.commander == (second or "anonymous")
    arbiter.command(61, Command(40.0, 12.0), first)  # who comes back is the second now
    assert arbiter.kept == Command(77.0, 6.0)


def test_who_sends_nothing_good_does_not_get_the_rig(arbiter):
    arbiter.command(1, Command(1e9, 12.0), OTHER)
    arbiter.command(2, Command(40.0, 12.0), DRIVER)
    assert arbiter.kept == Command(40.0, 12.0)
    assert arbiter.commander == DRIVER


def test_a_bad_command_is_no_silence(arbiter, clock):
    arbiter.command(1, Command(40.0, 12.0), DRIVER)
    for stamp in range(2, 30):
        clock.now += 0.1
        arbiter.command(stamp, Command(1e9, 12.0), DRIVER)
    arbiter.command(1, Command(77.0, 12.0), OTHER)
    assert arbiter.kept == Command(40.0, 12.0)


def test_a_single_value_beside_a_commander_is_refused_and_told(arbiter, clock):
    arbiter.command(1, Command(40.0, 12.0), DRIVER)
    arbiter.weight_on_bit(55.0)
    arbiter.speed(1.0)
    assert arbiter.kept == Command(40.0, 12.0)
    assert arbiter.refused == {"other_source": 2}
    assert "found a single value" in arbiter.last_refusal
    assert arbiter.refused_recently
    clock.now += 10.0
    assert not arbiter.refused_recently  # once is no state of affairs


def test_a_commander_that_fell_silent_loses_its_say(arbiter, clock):
    arbiter.command(1, Command(40.0, 12.0), DRIVER)
    clock.now += 1.1
    arbiter.weight_on_bit(55.0)
    assert arbiter.kept == Command(55.0, 12.0)
    assert arbiter.commander == "by hand"
    arbiter.command(2, Command(40.0, 12.0), OTHER)  # a commander goes before single values
    assert arbiter.kept == Command(40.0, 12.0)


def test_a_name_cannot_write_into_the_log(arbiter):
    arbiter.command(1, Command(40.0, 12.0), "\x1b[2J" + 1000 * "x")
    assert arbiter.commander.isprintable()
    assert len(arbiter.commander) < 210


def test_silence_holds_the_last_set_point_unless_a_ramp_is_wanted(arbiter, clock):
    arbiter.command(1, Command(40.0, 12.0))
    assert not any(quantity.silent for quantity in arbiter.quantities)
    clock.now += 1.1
    assert all(quantity.silent for quantity in arbiter.quantities)
    assert arbiter.age == pytest.approx(1.1)
    assert arbiter.set_point(0.01) == Command(40.0, 12.0)


def test_the_ramps_to_the_safe_set_point_and_to_the_next_commands_take_their_time(make, clock):
    arbiter = make(on_silence="ramp", safe_weight_on_bit=10.0, safe_ramp_time=2.0)
    arbiter.command(1, Command(40.0, 12.0))
    assert arbiter.set_point(0.01) == Command(40.0, 12.0)
    clock.now += 5.0
    path = [arbiter.set_point(0.01) for _ in range(300)]
    assert path[99] == Command(pytest.approx(25.0), pytest.approx(6.0))
    assert path[200] == path[-1] == Command(10.0, 0.0)
    arbiter.weight_on_bit(50.0)
    back = [arbiter.set_point(0.01) for _ in range(201)]
    assert back[99] == Command(pytest.approx(30.0), 0.0)
    assert back[200] == Command(50.0, 0.0)
    arbiter.command(2, Command(60.0, 12.0))  # the weight has been commanded; the speed begins
    assert arbiter.set_point(0.01) == Command(60.0, pytest.approx(0.06))


AUTO_DRILLER, TOP_DRIVE = "/auto_driller", "/top_drive"


def test_weight_and_speed_have_a_commander_each(make, clock):
    arbiter = make(on_silence="ramp_if_lost", safe_ramp_time=1.0)
    for stamp in range(100):
        assert arbiter.command(stamp, Command(30.0, NONE, 0.0), AUTO_DRILLER) == ""
        assert arbiter.command(stamp, Command(NONE, 12.0, NONE), TOP_DRIVE) == ""
        assert advance(arbiter, clock, 1, 0.01) in (Command(30.0, 12.0), Command(0.0, 12.0))
    assert arbiter.commander == "/auto_driller (weight on bit), /top_drive (top-drive speed)"
    assert arbiter.command(100, Command(NONE, 9.0, NONE), AUTO_DRILLER) == "other_source"
    assert "expected commands of /top_drive alone, which has the top-drive speed until" in arbiter.last_refusal
    assert arbiter.command(100, Command(50.0, 11.0), TOP_DRIVE) == "other_source"
    assert arbiter.last_refusal.endswith(
        "found a command of /top_drive, whose top-drive speed is free; stop one of the two"
    )
    assert arbiter.kept == Command(30.0, 11.0)
    for stamp in range(101, 400):  # the auto-driller is gone
        arbiter.command(stamp, Command(NONE, 12.0, NONE), TOP_DRIVE)
        applied = advance(arbiter, clock, 1, 0.01)
    assert applied == Command(0.0, 12.0)
    assert arbiter.commander == TOP_DRIVE
    arbiter.command(400, Command(50.0, 11.0), TOP_DRIVE)
    assert advance(arbiter, clock, 1, 0.01) == Command(pytest.approx(5.0), 11.0)  # a tenth of the way


@pytest.fixture
def watched(make):
    """An arbiter that ramps where a source that sent at a rate is lost."""
    return make(on_silence="ramp_if_lost", safe_weight_on_bit=10.0, safe_ramp_time=1.0)


def advance(arbiter, clock, frames, each):
    for _ in range(frames):
        clock.now += each
        applied = arbiter.set_point(0.1)
    return applied


def test_a_source_that_sent_at_a_rate_and_is_lost_is_followed_by_the_ramp(watched, clock):
    for stamp in range(3):
        watched.command(stamp, Command(40.0, 12.0))
        advance(watched, clock, 1, 0.1)
    assert advance(watched, clock, 10, 0.1) == Command(40.0, 12.0)
    assert advance(watched, clock, 25, 0.1) == Command(10.0, 0.0)
    watched.weight_on_bit(20.0)
    assert advance(watched, clock, 11, 0.01) == Command(20.0, 0.0)  # not with the speed of who is gone


def test_a_source_of_which_all_is_refused_is_followed_by_the_ramp_and_keeps_the_rig(watched, clock):
    for stamp in range(3):
        watched.command(stamp, Command(40.0, 12.0), DRIVER)
        advance(watched, clock, 1, 0.1)
    for stamp in range(3, 40):
        watched.command(stamp, Command(5000.0, 12.0), DRIVER)
        applied = advance(watched, clock, 1, 0.1)
    assert applied == Command(10.0, 0.0)
    assert watched.last_was_refused
    assert (watched.commander, watched.quantities[0].source) == ("", DRIVER)
    watched.command(40, Command(20.0, 12.0), OTHER)
    assert watched.set_point(0.1) == Command(10.0, 0.0)
    watched.command(41, Command(40.0, 12.0), DRIVER)
    assert (watched.commander, watched.last_was_refused) == (DRIVER, False)


def test_what_was_sent_once_or_by_hand_is_held(watched, clock):
    """As `ros2 topic pub --once`: who sends one value wants it until the next."""
    for stamp in range(4):
        watched.command(stamp, Command(40.0, 12.0))
        assert advance(watched, clock, 100, 0.1) == Command(40.0, 12.0)
    for value in (30.0, 31.0, 32.0, 33.0):
        watched.weight_on_bit(value)
    assert advance(watched, clock, 100, 0.1) == Command(33.0, 12.0)


def test_neither_a_pause_nor_slow_frames_are_the_loss_of_a_source(watched, clock):
    for stamp in range(50):
        watched.command(stamp, Command(40.0, 12.0))
        assert advance(watched, clock, 2, 3.0) == Command(40.0, 12.0)
    clock.now += 100.0
    assert advance(watched, clock, 5, 0.01) == Command(40.0, 12.0)


def test_a_desk_that_heard_nothing_is_not_silent(arbiter, clock):
    clock.now += 1000.0
    assert not arbiter.heard
    assert not any(quantity.silent for quantity in arbiter.quantities)


def _given(weight=0.0, speed=0.0, *, negative=False):
    return SimpleNamespace(max_weight_on_bit=weight, max_speed=speed, negative_commands=negative)


def test_limits_follow_the_scene():
    limits = limits_for(load_scene("pa6_bench"), _given())
    assert limits.weight_on_bit == (0.0, pytest.approx(400.0))
    assert limits.rotation == (0.0, pytest.approx(20.0 * TURN))
    with pytest.raises(CommandError):
        limits.check(Command(-1.0, 0.0))
    left = limits_for(load_scene("pa6_bench", overrides={"rpm": "-180"}), _given())
    left.check(Command(10.0, -3.0 * TURN))
    record = limits_for(load_scene("ufrj_rig"), _given())
    record.check(Command(700.0, -0.1))
    with pytest.raises(CommandError):
        record.check(Command(1e9, 0.0))
    both = limits_for(load_scene("pa6_bench"), _given(50.0, 10.0, negative=True))
    assert both.weight_on_bit == (-50.0, 50.0)
    assert both.rotation == (-10.0, 2.0 * TURN)  # the scene's own 2 rev/s is always allowed


def test_a_refusal_is_news_for_a_while_and_counted_for_good(arbiter, clock):
    arbiter.weight_on_bit(30.0)
    assert not arbiter.refused_recently
    clock.now += 100.0
    arbiter.weight_on_bit(1e9)
    assert arbiter.refused_recently
    clock.now += 11.0
    assert not arbiter.refused_recently
    assert arbiter.refused == {"out_of_range": 1}


def test_a_hand_command_is_known_from_that_of_a_driver(arbiter, clock):
    speed = arbiter.quantities[1]
    arbiter.command(1, Command(40.0, 12.0))
    assert not speed.by_hand
    clock.now += 1.1
    arbiter.speed(1.0)
    assert speed.by_hand
    arbiter.command(2, Command(40.0, 12.0))
    assert not speed.by_hand


def test_what_is_applied_during_a_ramp_is_not_the_last_command(make, clock):
    arbiter = make(on_silence="ramp", safe_ramp_time=4.0)
    arbiter.command(1, Command(40.0, 12.0))
    arbiter.set_point(0.01)
    assert arbiter.applied == Command(40.0, 12.0)
    clock.now += 2.0
    arbiter.set_point(1.0)
    assert arbiter.applied == arbiter.kept == Command(30.0, 9.0)
    weight, speed = arbiter.quantities
    assert weight.good.completed(speed.good) == Command(40.0, 12.0)


def test_a_safe_set_point_beyond_the_limits_is_refused(make):
    for beyond in ({"safe_weight_on_bit": 500.0}, {"safe_weight_on_bit": -50.0}, {"safe_speed": 30.0 * TURN}):
        with pytest.raises(ParameterError, match=r"safe_weight_on_bit, safe_speed: .* expected 0 to"):
            make(**beyond)
    make(safe_weight_on_bit=-50.0, negative_commands=True)


def test_commands_under_way_from_before_a_reset_are_known_however_many_and_another_clock_is_none_of_them(make):
    period, second = 10_000_000, 10**9
    weight = make().quantities[0]
    stamps = CommandStamps("fast", period, lambda: 0)
    weight.follow(Command(30.0, 6.0), "/own", SIMULATED)
    weight.hear("/own", 100 * second, SIMULATED)
    weight.go_on(Command(30.0, 6.0))
    for frame in range(1, 1000):  # a driver may lag by any time as fast as possible
        assert weight.is_before_reset("/own", 100 * second + frame * period, stamps)
    assert not weight.is_before_reset("/own", 1_800_000_000 * second, stamps)
    assert not weight.is_before_reset("/own", period, stamps)
