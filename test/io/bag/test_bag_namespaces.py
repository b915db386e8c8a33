# SPDX-License-Identifier: Apache-2.0
"""Bags of twins in namespaces: read under the names of the contract, and chosen where there are several."""

from dataclasses import replace

import pytest

from drill_twin.core.errors import BagError
from drill_twin.io.bag.metadata import contract_topic
from drill_twin.io.bag.reader import Bag
from drill_twin.io.bag.writer import BagWriter
from drill_twin.io.messages.diagnostics import Level, Status, decode_diagnostics, encode_diagnostics
from drill_twin.io.messages.topics import CLOCK_TOPIC, DIAGNOSTICS, MARKS_STATE, TOPICS, TWIN_SCENE


@pytest.fixture
def write_twins(tmp_path, messages):
    """A bag with the same messages in several namespaces, and the diagnostics of all on one topic."""

    def write(*namespaces, odd=()):
        def named(topic, namespace):
            return topic if topic == DIAGNOSTICS else namespace + topic

        topics = {named(topic, space): topic for space in namespaces for topic in TOPICS}
        described = [replace(contract_topic(topic), name=name) for name, topic in topics.items()]
        described += [replace(contract_topic(topic), name=name) for name, topic in odd]
        folder = tmp_path / f"bag_{len(list(tmp_path.iterdir()))}"
        with BagWriter(folder, topics=described) as writer:
            for topic, stamp, raw in messages:
                for space in namespaces:
                    content = raw
                    if topic == DIAGNOSTICS:
                        status = Status(f"{space}/simulator".lstrip("/"), Level.OK, "", {}, f"drill_twin{space}")
                        content = encode_diagnostics(stamp, [status])
                    writer.write(named(topic, space), stamp, content)
            for name, topic in odd:
                writer.write(name, 0, next(raw for known, _, raw in messages if known == topic))
        return folder

    return write


def test_a_twin_in_a_namespace_is_read_as_one_without(write_twins, messages):
    bag = Bag(write_twins("/rig2"))
    assert bag.namespace == "/rig2"
    assert [row for row in bag.messages() if row[0] != DIAGNOSTICS] == [
        row for row in messages if row[0] != DIAGNOSTICS
    ]
    assert set(bag.topics) == set(TOPICS)
    assert bag.scene() == Bag(write_twins("")).scene()


def test_nested_namespaces_and_names_like_ours(write_twins):
    assert Bag(write_twins("/field/rig")).namespace == "/field/rig"


@pytest.mark.parametrize(("spaces", "names"), [(("/left", "/right"), "/left, /right"), (("", "/rig2"), "/, /rig2")])
def test_two_twins_in_a_bag_are_chosen_by_namespace(write_twins, messages, spaces, names):
    folder = write_twins(*spaces)
    with pytest.raises(BagError, match=f"found twins of the namespaces {names}; choose with --namespace"):
        Bag(folder)
    for space in spaces:
        for given in (space or "/", space.strip("/") + "/"):
            bag = Bag(folder, namespace=given)
            assert bag.namespace == space
            assert [raw for *_, raw in bag.messages((MARKS_STATE,))] == [
                raw for topic, _, raw in messages if topic == MARKS_STATE
            ]
            reports = [decode_diagnostics(raw)[1][0].hardware_id for *_, raw in bag.messages((DIAGNOSTICS,))]
            assert reports
            assert set(reports) == {f"drill_twin{space}"}
    with pytest.raises(BagError, match=f"expected a twin in the namespace /other, found {names}"):
        Bag(folder, namespace="other")


def test_a_single_topic_elsewhere_is_no_second_twin(write_twins):
    """Such as a scene that another tool has published again: without states of marks or rig there is no twin."""
    assert Bag(write_twins("", odd=[("/copy/twin/scene", TWIN_SCENE)])).namespace == ""


def test_the_clock_of_the_domain_is_used_where_the_twin_has_none(tmp_path, messages):
    names = {MARKS_STATE: "/rig2/marks/state", CLOCK_TOPIC: CLOCK_TOPIC}
    with BagWriter(
        tmp_path / "bag_0", topics=[replace(contract_topic(topic), name=name) for topic, name in names.items()]
    ) as writer:
        for topic, stamp, raw in messages:
            if topic in names:
                writer.write(names[topic], stamp, raw)
    bag = Bag(tmp_path / "bag_0")
    assert bag.topics[CLOCK_TOPIC].count == sum(topic == CLOCK_TOPIC for topic, *_ in messages)
    assert [row[0] for row in bag.messages()] == [topic for topic, *_ in messages if topic in names]


def test_topics_of_other_names_are_mapped_beside_those_of_a_namespace(write_twins):
    folder = write_twins("/rig2", odd=[("/camera/marks", MARKS_STATE)])
    with pytest.raises(BagError, match="expected no topic /rig2/marks/state beside /camera/marks"):
        Bag(folder, names={"/camera/marks": MARKS_STATE})
    bag = Bag(folder, names={"/camera/marks": MARKS_STATE, "/rig2/marks/state": "/other"})
    assert (bag.topics[MARKS_STATE].count, bag.topics["/other"].count) == (1, 40)
