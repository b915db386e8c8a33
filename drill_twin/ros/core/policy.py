# SPDX-License-Identifier: Apache-2.0
"""Rights of a node, and the SROS2 policy that grants them and nothing else."""

import re
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from drill_twin.io.messages.topics import OF_SUBS, OF_TF, TOPICS

ALL_TOPICS = {row.name.replace("SUB", "*"): row for row in (*TOPICS.values(), *OF_TF.values(), *OF_SUBS)}
"""Topics of the contract by name, with `*` for the name of a sub."""
READY = ("simulator/ready", "analyzer/ready", "recorder/ready")
"""Services that a node calls which waits for the others."""
_OF_EVERY_NODE = {"/diagnostics", "/parameter_events", "/rosout", "~/transition_event"}
_SERVICES = {
    f"~/{name}"
    for name in (
        "change_state", "describe_parameters", "get_available_states", "get_available_transitions",
        "get_parameter_types", "get_parameters", "get_state", "get_transition_graph", "get_type_description",
        "list_parameters", "ready", "set_parameters", "set_parameters_atomically",
    )
}  # fmt: skip


@dataclass(frozen=True)
class Rights:
    """Topics and services that only some nodes have; names under the node begin with `~/`, `*` stands for any sub."""

    subscribes: tuple[str, ...] = ()
    services: tuple[str, ...] = ()
    calls: tuple[str, ...] = ()
    publishes: tuple[str, ...] = ()
    """Topics that the table of topics does not give to the node."""

    def own(self, name: str) -> dict[str, set[str]]:
        """Names by right, `publish`, `subscribe`, `reply` and `request`, of the node of a name."""
        listed = {topic for topic, row in ALL_TOPICS.items() if name in re.split(r"\W+", row.publisher)}
        return {
            "publish": {*listed, *self.publishes},
            "subscribe": set(self.subscribes),
            "reply": set(self.services),
            "request": set(self.calls),
        }


def policy_text(name: str, rights: Rights) -> str:
    """Policy of a node for `ros2 security`; its names are relative to the namespace of the node."""
    root = ET.Element("policy", version="0.2.0")
    enclave = ET.SubElement(ET.SubElement(root, "enclaves"), "enclave", path=f"/drill_twin/{name}")
    profile = ET.SubElement(ET.SubElement(enclave, "profiles"), "profile", ns="/", node=name)
    for right, names in rights.own(name).items():
        kind = "topic" if right in {"publish", "subscribe"} else "service"
        allowed = names | {"publish": _OF_EVERY_NODE, "reply": _SERVICES}.get(right, set())
        group = ET.SubElement(profile, f"{kind}s", {right: "ALLOW"}) if allowed else profile
        for each in sorted(allowed):
            ET.SubElement(group, kind).text = each.lstrip("/")
    ET.indent(root)
    return f"{ET.tostring(root, 'unicode', xml_declaration=True)}\n"
