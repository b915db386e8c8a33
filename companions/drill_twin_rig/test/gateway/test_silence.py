# SPDX-License-Identifier: Apache-2.0
"""Silence of a topic as the gateway judges it: each topic by the longest interval at which it comes."""

from drill_twin.io.messages.cdr import JointStateTemplate
from drill_twin.io.messages.diagnostics import Level
from drill_twin.io.messages.good_samples import GoodSamples
from drill_twin.io.messages.topics import ADVICE_STATE
from drill_twin_rig.gateway.quantities import TwinQuantities


def test_advice_that_changed_often_and_then_stays_is_not_silent():
    now = [0.0]
    twin = TwinQuantities(GoodSamples(lambda: now[0]))
    names = ("target", "target/weight_on_bit", "target/rotation")
    advice = JointStateTemplate(names, velocity=False, effort=False).fill(0, [1.0, 40.0, 2.0])
    for _ in range(12):  # on change, ten times a second
        twin.take(ADVICE_STATE, advice)
        now[0] += 0.1
    now[0] += 2.5  # the advisor repeats it after 1 s; a loaded machine takes longer
    assert twin.samples.verdict() == (Level.OK, "")
    now[0] += 1.0
    assert twin.samples.verdict()[0] is Level.STALE


def test_a_gateway_that_shows_nothing_waits_for_nothing():
    now = [0.0]
    samples = GoodSamples(lambda: now[0])
    samples.expect()
    now[0] = 60.0
    assert samples.verdict() == (Level.OK, "")
