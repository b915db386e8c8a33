# SPDX-License-Identifier: Apache-2.0
"""Table for people: columns and rows once, rendered for a terminal, as Markdown, CSV or HTML."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

from drill_twin.core.errors import printable

if TYPE_CHECKING:
    from rich.table import Table as RichTable
    from rich.text import Text


class Column(NamedTuple):
    """Column of a table."""

    heading: str
    """Words above it."""
    unit: str = ""
    """Unit of its values; empty where it has none, or where each cell names its own."""
    right: bool = False
    """Aligned to the right, as numbers are."""
    whole: bool = False
    """Cells are not broken into lines in a narrow terminal."""

    @property
    def title(self) -> str:
        """Heading with the unit in brackets."""
        return f"{self.heading} [{self.unit}]" if self.unit else self.heading


class Table:
    """Columns and rows; a console of rich prints it (`__rich__`).

    Cells are texts, or numbers, of which `str` is shown and None is left empty; a `rich.text.Text` keeps its style in
    a terminal. A table without columns is one of names and values: two columns, without headings.
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
            right: Numbers of the columns aligned to the right, of those given by their heading.
        """
        self.columns = [
            one if isinstance(one, Column) else Column(one, right=number in right) for number, one in enumerate(columns)
        ]
        self.rows = [tuple(row) for row in rows]
        self.title = title

    def __rich__(self) -> RichTable:
        """For a terminal: headings above a line, or names in bold before their values."""
        from rich import box
        from rich.table import Table as RichTable
        from rich.text import Text

        if self.columns:
            table = RichTable(
                box=box.SIMPLE_HEAD,
                title=Text(self.title, "table.title") if self.title else None,
                title_justify="left",
                padding=(0, 1),
                pad_edge=False,
            )
        else:
            table = RichTable(show_header=False, box=None, padding=(0, 2, 0, 0))
            table.add_column(style="bold", no_wrap=True)
        for column in self.columns:
            justify: Any = "right" if column.right else "left"
            table.add_column(Text(column.title), justify=justify, overflow="fold", no_wrap=column.whole)
        for row in self.rows:
            table.add_row(*map(_in_terminal, row))
        return table

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
        head = "".join(f"<th>{escape(column.title)}</th>" for column in self.columns)
        kinds = [' class="number"' if of.right else ' class="name"' if of.whole else "" for of in self.columns]
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


def markdown_row(cells: Sequence[object]) -> str:
    """Line of a Markdown table."""
    return f"| {' | '.join(' '.join(_shown(cell).replace('|', chr(92) + '|').split()) for cell in cells)} |"


def _shown(cell: object) -> str:
    return "" if cell is None else str(cell)


def _in_terminal(cell: object) -> Text:
    from rich.text import Text

    return cell if isinstance(cell, Text) else Text(printable(_shown(cell), keep=""))
