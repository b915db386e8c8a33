# SPDX-License-Identifier: Apache-2.0
"""Permissions of the nodes, and their SROS2 policy files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from drill_twin.core.companions import entries
from drill_twin.io.messages.topics import (
    CLOCK_TOPIC,
    COMMANDER,
    DIAGNOSTICS,
    MARKS_STATE,
    MEASURED,
    OF_SUBS,
    REALTIME_FACTOR,
    RIG_COMMAND,
    RIG_STATE,
    RPS_COMMAND,
    STRING_MARKERS,
    STRING_POSES,
    STRING_STRESS,
    SURFACE_STATE,
    TOPICS,
    TWIN_SCENE,
    TWIN_SUMMARY,
    WHIRL_MOTION,
    WHIRL_ONSET,
    WHIRL_STATE,
    WOB_COMMAND,
)
from drill_twin.ros.simulator.run_control import SERVICES

_OWN_SERVICES = (
    "~/change_state",
    "~/describe_parameters",
    "~/get_available_states",
    "~/get_available_transitions",
    "~/get_parameter_types",
    "~/get_parameters",
    "~/get_state",
    "~/get_transition_graph",
    "~/get_type_description",
    "~/list_parameters",
    "~/ready",
    "~/set_parameters",
    "~/set_parameters_atomically",
)
_CONTROLS = ("~/load_checkpoint", "~/pause", "~/reset", "~/resume", "~/save_checkpoint", "~/step")
_STANDARD = tuple(f"~/{name}" for name in SERVICES)
WHERE_INSTALLED = {"tf2_msgs": ("/tf", "/tf_static"), "simulation_interfaces": _STANDARD}
"""Topics and services that the simulator has if these packages are installed; the wheels have neither."""
_OF_EVERY_NODE = ("/parameter_events", "/rosout", DIAGNOSTICS, "~/transition_event")


@dataclass(frozen=True)
class Rights:
    """Permissions of a node."""

    publish: Sequence[str] = ()
    """Topics it publishes, beside those of every node."""
    subscribe: Sequence[str] = ()
    """Topics it subscribes to."""
    reply: Sequence[str] = ()
    """Services it offers, beside those of every node."""
    request: Sequence[str] = ()
    """Services it calls."""


SUBS, MEASURED_SUBS = (
    tuple(row.name.replace("SUB", "*") for row in OF_SUBS if row.name.startswith(MEASURED) is measured)
    for measured in (False, True)
)
"""Topics of subs, simulated and measured, with * for the name of any sub."""
READINGS = tuple(name for name in (*SUBS, *MEASURED_SUBS) if name.endswith("/imu"))
"""Those of their readings."""
_READY = ("analyzer/ready", "recorder/ready", "simulator/ready")
RIGHTS: dict[str, Rights] = {
    "simulator": Rights(
        (
            *(RIG_STATE, STRING_POSES, MARKS_STATE, STRING_MARKERS, TWIN_SCENE, REALTIME_FACTOR, CLOCK_TOPIC),
            COMMANDER,
            *(STRING_STRESS, SURFACE_STATE, *SUBS),
            *WHERE_INSTALLED["tf2_msgs"],
        ),
        (RIG_COMMAND, WOB_COMMAND, RPS_COMMAND),
        (*_CONTROLS, *_STANDARD),
    ),
    "rig_driver": Rights((RIG_COMMAND,), (CLOCK_TOPIC,), (), _READY),
    "analyzer": Rights(
        (WHIRL_STATE, WHIRL_MOTION, WHIRL_ONSET, TWIN_SUMMARY),
        (TWIN_SCENE, MARKS_STATE, RIG_STATE, REALTIME_FACTOR, *READINGS),
    ),
    "recorder": Rights((), (*TOPICS, *SUBS, *MEASURED_SUBS)),
    "replayer": Rights((*(topic for topic in TOPICS if topic != DIAGNOSTICS), *SUBS, *MEASURED_SUBS), (), (), _READY),
}
"""Rights of the nodes of the core: least privilege, which a test compares with what running nodes use."""
GROUP = "drill_twin.rights"
"""Entry-point group of the `Rights` of nodes in other packages, by the name of the node."""


def all_rights() -> dict[str, Rights]:
    """Rights of all nodes that are installed."""
    return RIGHTS | {entry.name: entry.load() for entry in entries(GROUP)}


def policy_text(node: str) -> str:
    """SROS2 policy of a node, `config/security/NODE.policy.xml`."""
    rights = all_rights()[node]
    publish = sorted({*_OF_EVERY_NODE, *rights.publish})
    lists = (
        ("topics", "publish", "topic", publish),
        ("topics", "subscribe", "topic", sorted(rights.subscribe)),
        ("services", "reply", "service", sorted({*_OWN_SERVICES, *rights.reply})),
        ("services", "request", "service", sorted(rights.request)),
    )
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f"<!-- What the node {node} may do, and nothing else; ros2 security generate_artifacts -k KEYS -p THIS_FILE.",
        "     Names are relative to the namespace of the node. -->",
        '<policy version="0.2.0">',
        "  <enclaves>",
        f'    <enclave path="/drill_twin/{node}">',
        "      <profiles>",
        f'        <profile ns="/" node="{node}">',
    ]
    for group, right, item, names in lists:
        if names:
            lines.append(f'          <{group} {right}="ALLOW">')
            lines += [f"            <{item}>{name.removeprefix('/')}</{item}>" for name in names]
            lines.append(f"          </{group}>")
    return "\n".join(
        [*lines, "        </profile>", "      </profiles>", "    </enclave>", "  </enclaves>", "</policy>", ""]
    )
