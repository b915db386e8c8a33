# SPDX-License-Identifier: Apache-2.0
"""Time log of WITSML 1.4.1 (Energistics 2011), read as a stream by expat.

A document type, which no log has, is refused. So is every entity, internal or external, that expat would expand or
fetch. Therefore the standard library is as safe here as defusedxml, which refuses the same; and as no tree is built, a
file of 200 MB takes the memory of its numbers.
"""

from pathlib import Path
from typing import Any
from xml.parsers import expat

from drill_twin.core.errors import TableError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.scene.records.columns import Columns
from drill_twin.scene.records.rows import LARGEST_FILE, MOST_COLUMNS, RecordRows, RowError

WITSML = ForeignFile("a WITSML log", LARGEST_FILE, TableError, may_be_empty=False)
_VERSION = "1.4.1"
_TIME = ("date time", "elapsed time")
_TEXTS = ("indexType", "indexCurve", "nullValue", "dataDelimiter", "mnemonicList", "unitList", "data")
_DEEPEST, _LONGEST_TEXT, _CHUNK = 20, 1_000_000, 2**18
_NONE = ("unitless", "none", "euc", "----")
"""Units of WITSML that say that there is none."""


class _RefusedError(Exception):
    """A document that is not taken; the text says what was expected and found."""


class _LogReader:
    """Handlers of the parser: header and numbers of one log."""

    def __init__(self) -> None:
        self.header: dict[str, str] = {}
        self.rows: RecordRows | None = None
        self._open: list[str] = []
        self._text: list[str] = []
        self._length = self._logs = 0

    def start(self, name: str, attributes: dict[str, str]) -> None:
        name = name.rpartition(" ")[2]
        if not self._open and (name != "logs" or not attributes.get("version", "").startswith(_VERSION)):
            found = f"<{name[:40]}> of version {attributes.get('version', 'none')[:20]}"
            raise _RefusedError(f'expected <logs version="{_VERSION}.1"> of WITSML, found {found}')
        if len(self._open) >= _DEEPEST:
            raise _RefusedError(f"expected elements at most {_DEEPEST} deep, found more")
        self._logs += name == "log"
        if self._logs > 1:
            raise _RefusedError("expected one log, found more; export them one by one")
        self._open.append(name)
        self._text, self._length = [], 0

    def text(self, data: str) -> None:
        self._length += len(data)
        if self._length > _LONGEST_TEXT:
            raise _RefusedError(f"expected texts of at most {_LONGEST_TEXT} characters, found a longer one")
        self._text.append(data)

    def end(self, name: str) -> None:
        name = name.rpartition(" ")[2]
        if name in _TEXTS and {*self._open[-2:-1]} & {"log", "logData"}:
            content = "".join(self._text).strip()
            if name == "data":
                self._row(content)
            else:
                self.header[name] = content
        self._open.pop()
        self._text = []

    def refuse(self, *_: Any) -> None:
        raise _RefusedError("expected no document type (<!DOCTYPE>), found one; no log of WITSML has it")

    def _row(self, content: str) -> None:
        self.rows = rows = self.rows or self._begin()
        try:
            rows.add(content)
        except RowError as error:
            raise _RefusedError(f"row {rows.count + 1}: {error}") from None
        if 0 in rows.texts:
            raise _RefusedError(f'expected a time in row {rows.count}, found "{rows.texts[0].cell}"')

    def _begin(self) -> RecordRows:
        if (kind := self.header.get("indexType", "none")) not in _TIME:
            raise _RefusedError(
                f'expected a log over time (indexType "date time"), found "{kind[:40]}"; export that one'
            )
        if len(self.header.get("dataDelimiter") or ",") != 1:
            raise _RefusedError(
                f'expected a dataDelimiter of one character, found "{self.header["dataDelimiter"][:40]}"'
            )
        names = [name.strip() for name in self.header.get("mnemonicList", "").split(",")]
        if not 1 < len(names) <= MOST_COLUMNS:
            raise _RefusedError(f"expected 2 to {MOST_COLUMNS} names in mnemonicList, found {len(names)}")
        return RecordRows(names, self.header.get("dataDelimiter") or ",")

    def columns(self, path: Path) -> Columns:
        """The columns of numbers, the index first and in s."""
        if self.rows is None:
            raise _RefusedError("expected <data> in the log, found none; export the log with its data")
        units = dict(zip(self.rows.names, map(str.strip, self.header.get("unitList", "").split(",")), strict=False))
        units = {name: unit for name, unit in units.items() if unit not in _NONE}
        return self.rows.columns(path, units, self.header.get("nullValue", ""))


def read_witsml(path: Path) -> Columns:
    """Read a time log; its nullValue and -999.25 are missing values, columns of text are left out.

    Raises:
        TableError: The file is no time log.
    """
    reader = _LogReader()
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.StartElementHandler, parser.EndElementHandler = reader.start, reader.end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = reader.text, reader.refuse
    try:
        with WITSML.open(path) as stream:
            fed = 0
            while chunk := stream.read(_CHUNK):
                parser.Parse(chunk, False)
                fed += len(chunk)
                if fed - parser.CurrentByteIndex > 2 * _LONGEST_TEXT:  # expat begins such a tag anew with each chunk
                    raise _RefusedError(f"expected tags of at most {_LONGEST_TEXT} characters, found a longer one")
            parser.Parse(b"", True)
        return reader.columns(path)
    except _RefusedError as error:
        told = str(error)
    except (expat.ExpatError, OSError, ValueError, LookupError) as error:
        told = f"expected a WITSML log, found {' '.join(str(error).split())[:200]}; export it again"
    raise TableError(f"{path}:{parser.CurrentLineNumber}: {told}")
