# SPDX-License-Identifier: Apache-2.0
"""Table for people: columns and rows once, rendered for a terminal, as Markdown, CSV or HTML."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Iterable, Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING, NamedTuple

from drill_twin.core.errors import printable

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions
    from rich.table import Table as RichTable
    from rich.text import Text


_BROKEN = 20  # characters


class Column(NamedTuple):
    """Column of a table."""

    heading: str
    """Words above the column."""
    unit: str = ""
    """Unit of the values; empty where they have none, or where each cell names its own."""
    right: bool = False
    """Aligned to the right, as numbers are."""
    whole: bool = False
    """Cells are not broken into lines in a narrow terminal; cells aligned to the right never are."""
    broken: bool = False
    """Words longer than `_BROKEN` are broken too in a narrow terminal, as a path is."""

    @property
    def title(self) -> str:
        """Heading with the unit in brackets."""
        return f"{self.heading} [{self.unit}]" if self.unit else self.heading


class Table:
    """Columns and rows; a console of rich prints it (`__rich_console__`).

    Cells are texts, or numbers, of which `str` is shown and None is left empty; a `rich.text.Text` keeps its style in
    a terminal. A table without columns has two: names and values, without headings.
    """

    def __init__(
        self,
        columns: Sequence[Column | str],
        rows: Iterable[Sequence[object]],
        *,
        title: str = "",
        right: Collection[int] = (),
    ) -> None:
        """Make a table.

        Args:
            columns: Columns, or their headings.
            rows: Cells by row.
            title: Words above the table in a terminal.
            right: Numbers of the columns to be aligned to the right, among columns given by their heading.
        """
        self.columns = [
            one if isinstance(one, Column) else Column(one, right=number in right) for number, one in enumerate(columns)
        ]
        self.rows = [tuple(row) for row in rows]
        self.title = title

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RichTable | Text]:
        """For a terminal: headings above a line, or names in bold before their values.

        Lines are broken between words, and cells to the right never. A table that is too wide for that has its rows
        and columns exchanged, or is printed row by row, headings before their values.
        """
        from rich import box
        from rich.table import Table as RichTable
        from rich.text import Text

        if self.title:
            yield Text(self.title, "table.title")
        if not self.columns:
            table = RichTable(show_header=False, box=None, padding=(0, 2, 0, 0))
            table.add_column(style="bold", no_wrap=True)
        elif widths := _widths(self, console, options):
            table = RichTable(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
            for column, width in zip(self.columns, widths, strict=True):
                table.add_column(
                    Text(column.title), justify="right" if column.right else "left", width=width, overflow="fold"
                )
        elif _widths(turned := _turned(self), console, options):
            yield from turned.__rich_console__(console, options)
            return
        else:
            for row in self.rows:
                named = zip((column.title for column in self.columns), row, strict=True)
                pairs = [(name, cell) for name, cell in named if _shown(cell)]
                yield from Table((), pairs).__rich_console__(console, options)
            return
        for row in self.rows:
            table.add_row(*map(_in_terminal, row))
        yield table
        yield Text()

    def text(self) -> str:
        """Plain text, as wide as the terminal or 80 characters."""
        from rich.console import Console

        with (console := Console(color_system=None, force_jupyter=False, highlight=False)).capture() as captured:
            console.print(self)
        return "\n".join(line.rstrip() for line in captured.get().rstrip().split("\n"))

    def markdown(self) -> str:
        """Markdown, lines joined and not ended: a pipe in a cell is escaped."""
        return "\n".join([self.markdown_head(), *map(markdown_row, self.rows)])

    def markdown_head(self) -> str:
        """Lines of the headings, for a table whose rows are printed one by one (`markdown_row`)."""
        marks = ("---:" if column.right else "---" for column in self.columns)
        return f"{markdown_row([column.title for column in self.columns])}\n| {' | '.join(marks)} |"

    def csv(self) -> str:
        """CSV with a line of headings."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(column.title for column in self.columns)
        writer.writerows(self.rows)
        return text.getvalue()

    def html(self, *, named: bool = True) -> str:
        """Element `table`, for `page.css`.

        Args:
            named: The first cell of a row is its name.
        """
        kinds = [
            ' class="number"' if column.right else ' class="name"' if column.whole else "" for column in self.columns
        ]
        head = "".join(
            f"<th{kind}>{escape(column.title)}</th>" for column, kind in zip(self.columns, kinds, strict=True)
        )
        body = "".join(
            "<tr>"
            + "".join(
                f"<th>{escape(_shown(cell))}</th>"
                if named and number == 0
                else f"<td{kind}>{escape(_shown(cell))}</td>"
                for number, (cell, kind) in enumerate(zip(row, kinds or [""] * len(row), strict=True))
            )
            + "</tr>"
            for row in self.rows
        )
        return f"<table>{f'<thead><tr>{head}</tr></thead>' if head else ''}<tbody>{body}</tbody></table>"


class Shown:
    """Object that a prompt and a notebook show as a table of one screen."""

    def shown(self) -> Table:
        """Table of what the object is."""
        raise NotImplementedError

    def __repr__(self) -> str:
        """The table as text."""
        return self.shown().text()

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """The table for a notebook, its title above it."""
        table = self.shown()
        return f"<p>{escape(table.title)}</p>{table.html()}"


def markdown_row(cells: Sequence[object]) -> str:
    """Line of a Markdown table."""
    return f"| {' | '.join(' '.join(_shown(cell).replace('|', chr(92) + '|').split()) for cell in cells)} |"


def _shown(cell: object) -> str:
    return "" if cell is None else str(cell)


def _in_terminal(cell: object) -> Text:
    from rich.text import Text

    return cell if isinstance(cell, Text) else Text(printable(_shown(cell), keep=""))


def _turned(table: Table) -> Table:
    """A table with rows and columns exchanged, without its title."""
    first, *others = table.columns
    columns = [first, *(Column(_shown(row[0]), right=True) for row in table.rows)]
    return Table(columns, zip([column.title for column in others], *(row[1:] for row in table.rows), strict=True))


def _widths(table: Table, console: Console, options: ConsoleOptions) -> list[int]:
    """Width of each column: the widest shrink, at most to their longest word; none where that is not enough."""
    from rich.measure import Measurement
    from rich.text import Text

    least, widths = [], []
    for number, column in enumerate(table.columns):
        heading = Measurement.get(console, options, Text(column.title))
        cells = [Measurement.get(console, options, _in_terminal(row[number])) for row in table.rows]
        whole = column.whole or column.right
        longest = max([heading.minimum, *(cell.maximum if whole else cell.minimum for cell in cells)])
        least.append(min(longest, _BROKEN) if column.broken else longest)
        widths.append(max(cell.maximum for cell in (heading, *cells)))
    for _ in range(sum(widths) + 3 * (len(widths) - 1) - options.max_width):
        able = [number for number, width in enumerate(widths) if width > least[number]]
        if not able:
            return []
        widths[max(able, key=widths.__getitem__)] -= 1
    return widths
