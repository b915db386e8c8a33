# SPDX-License-Identifier: Apache-2.0
"""Address space of the server: a variable and a data point for each signal, and the vocabulary that they refer to."""

from collections.abc import Sequence
from typing import Any

from asyncua import ua

from drill_twin.io.messages.topics import TOPICS
from drill_twin_rig.gateway.control import HEARTBEAT, HOLDER, PERMISSION, REFUSAL, REQUEST
from drill_twin_rig.gateway.dwis import (
    NAMESPACE,
    PROPOSED_NAMESPACE,
    PROTOTYPES,
    TO_CLASSES,
    UNITS,
    UNITS_OF_NODES,
    VERBS,
    Unit,
    classes,
    facts,
)
from drill_twin_rig.gateway.quantities import QUANTITIES
from drill_twin_rig.gateway.signals import CommandTarget, ShownSignal


class AddressSpace:
    """Nodes of a server that is not started yet; `begin` comes first."""

    async def begin(self, server: Any, application: str) -> None:
        """Create the folders and the verbs of D-WIS as types of references.

        Args:
            server: The server of asyncua, initialised.
            application: Namespace of the nodes of signals.
        """
        self._spaces = {uri: await server.register_namespace(uri) for uri in (NAMESPACE, PROPOSED_NAMESPACE)}
        self._own = await server.get_namespace_index(application)
        self._nouns: dict[str, Any] = {}
        self.root = await server.nodes.objects.add_object(*_named("DrillTwin", self._own))
        """Object that holds all of the gateway."""
        self._signals, self._points, self._vocabulary = [
            await self.root.add_folder(*_named(name, self._own)) for name in ("Signals", "DataPoints", "Vocabulary")
        ]
        links = server.get_node(ua.ObjectIds.NonHierarchicalReferences)
        index = self._spaces[NAMESPACE]
        self._verbs = {verb: await links.add_reference_type(*_named(verb, index), False) for verb in VERBS}

    async def add_signal(self, signal: ShownSignal) -> Any:
        """Add the nodes of a signal; returns the node id of its variable."""
        variable = await self._signals.add_variable(
            *_named(signal.name, self._own), ua.Variant(0.0, ua.VariantType.Double)
        )
        meaning, ours = QUANTITIES[signal.quantity].meaning, signal.kind not in PROTOTYPES
        if ours:
            meaning += " (class proposed by drill_twin, not of D-WIS)"
        await self.describe(variable, meaning, signal.unit)
        point = await self._points.add_object(*_named(f"{signal.name}#01", self._own))
        await self.link(point, "HasDynamicValue", variable)
        await self.link(point, "BelongsToClass", await self._noun(signal.kind, ours=ours))
        for verb, noun in facts(signal.kind, signal.quantity):
            await self.link(point, verb, await (self._noun(noun) if verb in TO_CLASSES else self._one_of(noun)))
        if (node := TOPICS[QUANTITIES[signal.quantity].topic].publisher) in UNITS_OF_NODES:
            await self.link(point, "IsComputedBy", await self._one_of(*UNITS_OF_NODES[node]))
        empty = ua.DataValue(
            ua.Variant(0.0, ua.VariantType.Double), ua.StatusCode(ua.StatusCodes.BadWaitingForInitialData)
        )
        await variable.write_attribute(ua.AttributeIds.Value, empty)
        return variable.nodeid

    async def add_control(self, targets: Sequence[CommandTarget]) -> dict[str, Any]:
        """Add the nodes of control and the set-points; returns their ids by name."""
        folder = await self.root.add_object(*_named("Control", self._own))
        rows = (
            (REQUEST, ua.Variant(False), "true requests control, false gives it back"),
            (HEARTBEAT, ua.Variant(0, ua.VariantType.UInt32), "number that the holder changes to keep control"),
            (PERMISSION, ua.Variant(0, ua.VariantType.UInt16), "0 unset, 1 granted, 2 pending, 3 denied, 4 invalid"),
            (HOLDER, ua.Variant("", ua.VariantType.String), "user who has control"),
            (REFUSAL, ua.Variant("", ua.VariantType.String), "reason why the twin refuses the set-point of the holder"),
        )
        ids = {}
        for name, value, meaning in rows:
            node = await folder.add_variable(*_named(name, self._own), value)
            await node.write_attribute(ua.AttributeIds.Description, _text(meaning))
            ids[name] = node.nodeid
            if name in {REQUEST, HEARTBEAT}:
                await node.set_writable()
        for target in targets:
            node = await folder.add_variable(*_named(target.name, self._own), ua.Variant(0.0, ua.VariantType.Double))
            await node.set_writable()
            await self.describe(node, f"set-point of the {QUANTITIES[target.quantity].meaning}", target.unit)
            await self.link(node, "BelongsToClass", await self._noun("SetPoint"))
            ids[target.name] = node.nodeid
        return ids

    async def describe(self, variable: Any, meaning: str, unit: str) -> None:
        """Give a variable its description, its unit as an OPC UA property, and its class and unit in D-WIS."""
        await variable.write_attribute(ua.AttributeIds.Description, _text(meaning))
        known = UNITS.get(unit, Unit(unit))
        information = ua.EUInformation(
            NamespaceUri="http://www.opcfoundation.org/UA/units/un/cefact",
            UnitId=known.number,
            DisplayName=ua.LocalizedText(unit),
            Description=ua.LocalizedText(known.noun),
        )
        await variable.add_property(
            ua.NodeId(f"{variable.nodeid.Identifier}.EngineeringUnits", self._own),
            ua.QualifiedName("EngineeringUnits", 0),
            information,
        )
        await self.link(variable, "BelongsToClass", await self._noun("DynamicDrillingSignal"))
        if unit in UNITS:
            await self.link(variable, "HasUnitOfMeasure", await self._noun(known.noun))

    async def link(self, subject: Any, verb: str, noun: Any) -> None:
        """Add a reference, to be followed in both directions."""
        await subject.add_reference(noun, self._verbs[verb])

    async def _noun(self, name: str, *, ours: bool = False) -> Any:
        """Node of a noun, made when it is first used."""
        if name not in self._nouns:
            index = self._spaces[PROPOSED_NAMESPACE if ours else NAMESPACE]
            self._nouns[name] = await self._vocabulary.add_object(*_named(name, index))
        return self._nouns[name]

    async def _one_of(self, noun: str, feature: str = "") -> Any:
        """Node that belongs to a class, made when it is first used; it accounts for a feature where one is given."""
        name = f"{noun}#01"
        if name not in self._nouns:
            self._nouns[name] = one = await self._vocabulary.add_object(*_named(name, self._own))
            for parent in classes(noun):
                await self.link(one, "BelongsToClass", await self._noun(parent))
            if feature:
                await self.link(one, "AccountsFor", await self._one_of(feature))
        return self._nouns[name]


def _named(name: str, space: int) -> tuple[Any, Any]:
    """Node id and browse name of a node, by the index of its namespace."""
    return ua.NodeId(name, space), ua.QualifiedName(name, space)


def _text(text: str) -> Any:
    return ua.DataValue(ua.Variant(ua.LocalizedText(text)))
