# SPDX-License-Identifier: Apache-2.0
"""Reader of bags, complete or left by a killed writer.

Names of topics of a twin in a namespace, or of another package, are read as names of the contract.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path

from drill_twin.core.errors import BagError
from drill_twin.io.bag.metadata import RecordedTopic
from drill_twin.io.bag.reading.bag_file import BagFile
from drill_twin.io.bag.reading.files import open_files
from drill_twin.io.bag.skipped import stray_stamps
from drill_twin.io.messages.decode import read_string
from drill_twin.io.messages.stamps import DATED, counted_from, raw_header_stamp
from drill_twin.io.messages.topic_row import WITH_HEADER
from drill_twin.io.messages.topics import (
    DIAGNOSTICS,
    GENERIC,
    MARKS_STATE,
    MEASURED,
    RIG_STATE,
    TOPICS,
    TWIN_SCENE,
)

_HARDWARE = "drill_twin"
_NAMED = 8  # namespaces in an error
_FIRST = 64  # messages that tell whether stamps are dates


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
    """Namespaces of the twins in a bag, as "/rig2", or "" for the root: twins with states of marks or rig, if any."""
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
        BagError: The bag holds several twins and none was chosen, or the bag lacks the chosen twin.
    """
    found = twin_namespaces(topics)
    names = ", ".join(namespace or "/" for namespace in found[:_NAMED])
    names += f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
    if wanted is None:
        if len(found) > 1:
            raise BagError(
                f"{where}: expected one twin, found twins of the namespaces {names}; choose with --namespace"
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
        BagError: The bag has no topic of a given name, or already has a topic of the new name.
    """
    for name, wanted in remappings.items():
        if name not in topics:
            raise BagError(f"{where}: expected the topic {name} to read as {wanted}, found {', '.join(sorted(topics))}")
        present = namespace + wanted
        if present in topics and topics[present].count and present not in remappings:
            raise BagError(f"{where}: expected no topic {present} beside {name}, which is read as {wanted}, found both")
    inside = {name.removeprefix(namespace): name for name in topics if name.startswith(namespace)}
    own = {known: name for known, name in inside.items() if known in TOPICS}
    others = {name: name for name in topics if name not in TOPICS and name not in own.values()}
    generic = {name: name for name in GENERIC if name in topics and name not in own}
    given = {wanted: name for name, wanted in remappings.items()}
    read = {wanted: name for wanted, name in (own | others | generic).items() if name not in remappings}
    return read | given


def is_of_another_twin(diagnostics: bytes, namespace: str) -> bool:
    """True for `/diagnostics`, which all twins of a domain share, of a twin in another namespace, by its CDR."""
    own, root = f"{_HARDWARE}{namespace}\0".encode(), f"{_HARDWARE}\0".encode()
    return own not in diagnostics and (f"{_HARDWARE}/".encode() in diagnostics or root in diagnostics)


class Bag:
    """Bag with topics of the contract; it can be read any number of times.

    Attributes:
        path: Bag folder or file.
        topics: Topics by name; topics of a twin in a namespace have their names without the namespace.
        namespace: Namespace of the twin, as "/rig2"; "" for the root.
        origin: Time from which header stamps are counted [ns]; 0: as recorded.
        start, end: Earliest and latest time of recording [ns].
        damage: Sentences on missing or damaged parts; the rest of the bag can be read.
        notes: Sentences on what is unusual and harmless.
    """

    namespace = ""
    origin = 0  # ns

    def __init__(
        self,
        path: str | Path,
        *,
        names: Mapping[str, str] | None = None,
        namespace: str | None = None,
        window: tuple[float, float] | None = None,
    ) -> None:
        """Open a bag folder or a single file.

        Args:
            path: Bag folder, `.mcap` or `.db3` file.
            names: Names of the contract by the bag's names, for a bag that has others.
            namespace: Namespace of the twin to read; None: the only one.
            window: Header stamps [s] between which messages are wanted: a complete MCAP file is then read by its index,
                and messages outside may be left out. None: all.

        Raises:
            BagError: The path leads to no bag; the bag has no messages, or none on a topic of the contract; the bag
                holds several twins and none was chosen, or does not fit `names`.
        """
        self.path = Path(path)
        self._files, empty_files = open_files(self.path, window)
        self.damage: list[str] = [*(text for file in self._files for text in file.damage), *empty_files]
        self.notes = [text for file in self._files for text in file.notes]
        self._open_topics(_merged(self._files), names or {}, namespace)
        starts = [file.start for file in self._files if file.start is not None]
        ends = [file.end for file in self._files if file.end is not None]
        if not starts:
            raise BagError(f"{self.path}: expected messages, found none{self._because()}; record it again")
        self.start: int = min(starts)
        self.end: int = max(ends)
        self._check_topics()

    @property
    def truncated(self) -> bool:
        """True if the writer did not finish the bag, or a part of it is damaged."""
        return bool(self.damage)

    @property
    def message_count(self) -> int:
        """Number of messages on all topics."""
        return sum(topic.count for topic in self.topics.values())

    def messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time of recording [ns] and CDR of each message, in recorded order, with stamps from `origin` on.

        Args:
            topics: Names of topics to read; by default all.
        """
        origin, stamped = self.origin, self._stamped if self.origin else ()
        for topic, stamp, raw in self.recorded_messages(topics):
            yield topic, stamp, counted_from(raw, origin) if topic in stamped else raw

    def count_from_start(self) -> bool:
        """Count stamps from the first, where they are dates; False without stamps."""
        self._stamped = {name for name, topic in self.topics.items() if topic.type_name in WITH_HEADER}
        first = [raw_header_stamp(raw) for _, _, raw in islice(self.recorded_messages(self._stamped), _FIRST)]
        stray = stray_stamps(first)
        earliest = min((stamp for k, stamp in enumerate(first) if k not in stray and stamp > 0), default=0)
        self.origin = earliest if earliest >= DATED else 0
        return bool(first)

    def recorded_messages(self, topics: Collection[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """As `messages`, with stamps as they were recorded."""
        wanted = {self._recorded[name] for name in (self.topics if topics is None else topics) if name in self.topics}
        ours = {recorded: name for name, recorded in self._recorded.items()}
        for file in self._files:
            for recorded, stamp, raw in file.messages(wanted):
                if recorded != DIAGNOSTICS or not is_of_another_twin(raw, self.namespace):
                    yield ours[recorded], stamp, raw

    def last(self, topic: str) -> bytes | None:
        """CDR of the last message on a topic; None without messages."""
        raw = None
        for _, _, raw in self.messages((topic,)):  # noqa: B007  only the last value is used
            pass
        return raw

    def scene(self) -> str:
        """Resolved scene of the recorded run, a YAML text with a `run` block.

        Raises:
            BagError: The bag has no scene.
        """
        if (raw := self.last(TWIN_SCENE)) is None:
            raise BagError(f"{self.path}: expected the scene on {TWIN_SCENE}, found none; name the scene")
        return read_string(raw)

    def _because(self) -> str:
        return f" ({'; '.join(self.damage)})" if self.damage else ""

    def _open_topics(self, found: Mapping[str, RecordedTopic], names: Mapping[str, str], namespace: str | None) -> None:
        where = str(self.path)
        unnamed = {name: topic for name, topic in found.items() if name not in names}
        self.namespace = choose_namespace(unnamed, namespace, where)
        self._recorded = recorded_names(found, names, self.namespace, where)
        ours = {recorded: name for name, recorded in self._recorded.items()}
        self.topics: dict[str, RecordedTopic] = {ours[name]: topic for name, topic in found.items() if name in ours}

    def _check_topics(self) -> None:
        others = {
            name: topic
            for name, topic in self.topics.items()
            if name in TOPICS and topic.type_name != TOPICS[name].type_name
        }
        for name, topic in others.items():
            del self.topics[name]
            self.damage.append(
                f"expected {name} as {TOPICS[name].type_name}, found {topic.type_name}: "
                f"its {topic.count} messages are left out"
            )
        if not any(name in TOPICS and name not in GENERIC and topic.count for name, topic in self.topics.items()):
            found = ", ".join(f"{name} ({topic.type_name})" for name, topic in sorted(self.topics.items()))
            raise BagError(
                f"{self.path}: expected topics of drill_twin such as /string/poses "
                f"or /marks/state, found only {found or 'others'}{self._because()}; the bag is of another package"
            )


def _merged(files: Sequence[BagFile]) -> dict[str, RecordedTopic]:
    topics: dict[str, RecordedTopic] = {}
    for file in files:
        for name, topic in file.topics.items():
            if (known := topics.setdefault(name, topic)) is not topic:
                known.count += topic.count
    return topics
