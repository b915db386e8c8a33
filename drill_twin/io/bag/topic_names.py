# SPDX-License-Identifier: Apache-2.0
"""Names of topics in a bag: those of a twin in a namespace, or of another package, as names of the contract."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from drill_twin.core.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic
from drill_twin.io.messages.topics import GENERIC, MARKS_STATE, MEASURED, RIG_STATE, TOPICS, sub_of

_HARDWARE = "drill_twin"
_NAMED = 8  # namespaces in an error


def parse_remappings(pairs: Iterable[str], option: str) -> dict[str, str]:
    """Names of the contract by the bag's names, from texts such as "/camera/marks=/marks/state".

    Args:
        pairs: The texts.
        option: Option or parameter that gave them, for the error.

    Raises:
        BagError: A text is not such a pair.
    """
    names = {}
    for pair in pairs:
        theirs, equals, ours = (part.strip() for part in pair.partition("="))
        if not (equals and theirs and ours):
            raise BagError(f'{option}: expected THEIRS=OURS such as "/camera/marks=/marks/state", found "{pair}"')
        names[theirs] = ours
    return names


def twin_namespaces(topics: Mapping[str, RecordedTopic]) -> list[str]:
    """Namespaces of the twins in a bag, as "/rig2", or "" for the root: those with states of marks or rig, if any."""
    found: dict[str, set[str]] = {}
    for name, topic in topics.items():
        ends = [known for known in ends_of(name) if topic.type_name == TOPICS[known].type_name]
        known = max(ends, key=len, default="")  # /measured/rig/state is no /rig/state in a namespace
        if known and known not in GENERIC and topic.count:
            found.setdefault(name.removesuffix(known), set()).add(known)
    with_states = [namespace for namespace, held in found.items() if held & {MARKS_STATE, RIG_STATE}]
    return sorted(with_states or found)


def ends_of(name: str) -> list[str]:
    """Topics of the contract with which a name ends, in whatever namespace."""
    sub = name[name.rfind("/downhole/") :] if "/downhole/" in name else ""
    subs = [known for known in (sub, MEASURED + sub) if sub in TOPICS and name.endswith(known)]
    return [*(known for known in TOPICS if name.endswith(known)), *subs]


def choose_namespace(topics: Mapping[str, RecordedTopic], wanted: str | None, where: str) -> str:
    """Namespace of the twin to read, as "/rig2", or "" for the root.

    Args:
        topics: Topics of the bag.
        wanted: The namespace that the user chose; None: the only one.
        where: Path of the bag, for the error.

    Raises:
        BagError: The bag holds several twins and none was chosen, or not the one that was.
    """
    found = twin_namespaces(topics)
    names = ", ".join(namespace or "/" for namespace in found[:_NAMED])
    names += f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
    if wanted is None:
        if len(found) > 1:
            raise BagError(
                f"{where}: expected one twin, found those of the namespaces {names}; choose with --namespace"
            )
        return found[0] if found else ""
    chosen = f"/{wanted.strip('/')}".removesuffix("/")
    if chosen not in found:
        raise BagError(f"{where}: expected a twin in the namespace {chosen or '/'}, found {names or 'none'}")
    return chosen


def recorded_names(
    topics: Mapping[str, RecordedTopic], remappings: Mapping[str, str], namespace: str, where: str
) -> dict[str, str]:
    """Recorded name of each topic by the name under which it is read; topics of other twins are left out.

    Args:
        topics: Topics of the bag by recorded name.
        remappings: Names of the contract by the bag's names, which the user gave.
        namespace: Namespace of the twin to read.
        where: Path of the bag, for the error.

    Raises:
        BagError: The bag has no topic of a given name, or already one of the new name.
    """
    for name, wanted in remappings.items():
        if name not in topics:
            raise BagError(f"{where}: expected the topic {name} to read as {wanted}, found {', '.join(sorted(topics))}")
        present = namespace + wanted
        if present in topics and topics[present].count and present not in remappings:
            raise BagError(f"{where}: expected no topic {present} beside {name} that is to be read as it, found one")
    own = {known: namespace + known for known in TOPICS if namespace + known in topics}
    inside = {name.removeprefix(namespace): name for name in topics if name.startswith(namespace)}
    own |= {known: name for known, name in inside.items() if sub_of(known)}
    others = {name: name for name in topics if name not in TOPICS and name not in own.values()}
    generic = {name: name for name in GENERIC if name in topics and name not in own}
    given = {wanted: name for name, wanted in remappings.items()}
    read = {wanted: name for wanted, name in (own | others | generic).items() if name not in remappings}
    return read | given


def is_of_another_twin(diagnostics: bytes, namespace: str) -> bool:
    """True for `/diagnostics`, which all twins of a domain share, of a twin in another namespace, by its CDR."""
    own, root = f"{_HARDWARE}{namespace}\0".encode(), f"{_HARDWARE}\0".encode()
    return own not in diagnostics and (f"{_HARDWARE}/".encode() in diagnostics or root in diagnostics)
