# SPDX-License-Identifier: Apache-2.0
"""WITS level 0 over TCP, reading: a sentence begins with `&&`, has a line an item, and ends with `!!`.

A line is the number of the record and of the item, two digits each, and the value: `01163.25` is 3.25 of item 16 in
record 1, the weight on bit. An item carries no unit and no stamp: the line in the file of signals gives the unit,
and the stamp is the time at which its sentence was complete.
"""

import asyncio
import math
import time
from collections.abc import Iterator, Sequence
from urllib.parse import urlsplit

from drill_twin.core.missing import WORDS
from drill_twin.core.numerals import number
from drill_twin_rig.gateway.rig_reader import PATIENCE, RefusedError, RigReader, SignalReading
from drill_twin_rig.gateway.signals import RigSignal

BEGIN, END = "&&", "!!"
_LINE, _MOST_ITEMS = 256, 1000  # bytes; items of a sentence


class SentenceReader:
    """Items of the sentences in a stream of lines."""

    def __init__(self) -> None:
        self._items: dict[str, str] | None = None

    def take(self, line: str) -> dict[str, str] | None:
        """Take a line; returns the texts of all items, by their four digits, when a sentence is complete."""
        line = line.strip()
        if line == BEGIN:
            self._items = {}
        elif self._items is None:
            return None
        elif line == END:
            items, self._items = self._items, None
            return items
        elif len(line) > 4 and line[:4].isdecimal() and len(self._items) < _MOST_ITEMS:
            self._items[line[:4]] = line[4:].strip()
        return None


class WitsReader(RigReader):
    """Reader of a WITS level 0 server."""

    def __init__(self, url: str, signals: Sequence[RigSignal]) -> None:
        """Begin to read.

        Args:
            url: Address, as `wits://rig:5001`.
            signals: Signals to read; their nodes are `wits=0116`.
        """
        self._address = urlsplit(url)
        self._items = [signal.node.removeprefix("wits=") for signal in signals]
        self._found: dict[str, tuple[str, float]] = {}
        super().__init__(signals, 0.0)

    async def connect_and_read(self) -> None:
        """Connect, and take sentences until the connection ends.

        Raises:
            RefusedError: A line is longer than WITS allows.
        """
        opening = asyncio.open_connection(self._address.hostname, self._address.port, limit=_LINE)
        reader, writer = await asyncio.wait_for(opening, PATIENCE)
        try:
            self._connected()
            sentences = SentenceReader()
            async for line in reader:
                if items := sentences.take(line.decode("ascii", "replace")):
                    now = time.time()
                    self._found |= {item: (text, now) for item, text in items.items() if item in self._items}
                    self._take(self._readings())
        except ValueError as error:
            raise RefusedError(f"expected lines of WITS, found a line of more than {_LINE} bytes") from error
        finally:
            writer.close()

    def _readings(self) -> Iterator[SignalReading]:
        for item in self._items:
            text, stamp = self._found.get(item, ("", math.nan))
            found = math.nan if text.lower() in WORDS else number(text)
            yield SignalReading(text if found is None else found, "" if text else f"no item {item} so far", stamp)
