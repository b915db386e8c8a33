# SPDX-License-Identifier: Apache-2.0
"""A flood of scenes that take long to parse costs a node a tenth of its time; ordinary ones are passed on at once."""

import pytest

from drill_twin.ros.core.queues import SceneGate


class Parser:
    """Takes so much time for each scene."""

    def __init__(self, seconds):
        self.now, self.seconds, self.seen, self.busy = 0.0, seconds, [], 0.0

    def clock(self):
        return self.now

    def parse(self, raw):
        self.seen.append(raw)
        self.now += self.seconds
        self.busy += self.seconds


def flood(parser, count, period):
    gate = SceneGate(parser.parse, parser.clock)
    for number in range(count):
        parser.now += period
        gate.take(b"%d" % number)
        gate.work()
    return gate


def test_scenes_that_take_long_are_put_off_and_the_newest_is_used():
    parser = Parser(0.5)
    gate = flood(parser, 840, 0.1)
    assert parser.busy < 0.12 * parser.now
    assert gate.put_off > 700
    parser.now += 10.0
    gate.work()
    assert parser.seen[-1] == b"839"
    gate.work()
    assert parser.seen.count(b"839") == 1


@pytest.mark.parametrize("seconds", [0.0, 0.02])
def test_ordinary_scenes_are_passed_on_at_once(seconds):
    parser = Parser(seconds)
    gate = flood(parser, 50, 0.001)
    assert parser.seen == [b"%d" % number for number in range(50)]
    assert gate.put_off == 0
