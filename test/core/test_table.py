"""One table, four ways to show it."""

from rich.console import Console
from rich.text import Text

from drill_twin.core.table import Column, Table

TABLE = Table(
    (Column("mark", whole=True), Column("radius", "mm", right=True), "motion"),
    [("bit|1", 36.25, Text("spiral", "red")), ("\x1b[31mtop", None, "at <rest>")],
    title="Marks",
)


def printed(table, width=60):
    console = Console(width=width, color_system=None)
    with console.capture() as said:
        console.print(table)
    return said.get()


def test_a_terminal_shows_headings_with_units_and_no_control_characters():
    lines = [line.rstrip() for line in printed(TABLE).splitlines()]
    assert lines[0] == "Marks"
    assert lines[1].split() == ["mark", "radius", "[mm]", "motion"]
    assert lines[3].split() == ["bit|1", "36.25", "spiral"]
    assert lines[4].split() == ["\\x1b[31mtop", "at", "<rest>"]
    assert lines[1].index("[mm]") + 4 == lines[3].index("36.25") + 5  # to the right


def test_a_line_breaks_between_words_and_never_in_a_number():
    columns = ("name of it", Column("weight on bit", "N", right=True), Column("way", whole=True), "what decided it")
    row = ("motion", "1.5 to 250", "to the bit", "independent of the others")
    shown = [line.split() for line in printed(Table(columns, [row]), width=46).splitlines()]
    assert shown[0] == ["name", "weight", "on", "what"]
    assert shown[3] == ["motion", "1.5", "to", "250", "to", "the", "bit", "independent"]
    narrow = [line.rstrip() for line in printed(Table(columns, [row, row]), width=36).splitlines()]
    assert narrow[:5] == [
        "name of it         motion", "weight on bit [N]  1.5 to 250", "way                to the bit",
        "what decided it    independent of", "                   the others",
    ]  # fmt: skip


def test_a_word_longer_than_the_terminal_is_broken_where_the_column_says_so():
    path = "/home/a/very/long/path/of/an/environment/python"
    lines = printed(
        Table(("", "", Column("", broken=True)), [("ok", "numpy", path), ("ok", "scipy", "1.17")]), width=40
    )
    rows = [line.split() for line in lines.splitlines()]
    assert rows[2][:2] == ["ok", "numpy"]
    assert rows[2][2] + rows[3][0] == path
    assert rows[4] == ["ok", "scipy", "1.17"]


def test_numbers_that_are_too_wide_have_their_rows_and_columns_exchanged():
    columns = ("operation", *(Column(name, right=True) for name in ("hookload", "torque", "stretch", "turns")))
    rows = [("drill", 1.25, 0.5, 3, 4), ("slide", 2, 3, 4, 5)]
    lines = [line.split() for line in printed(Table(columns, rows, title="loads"), width=30).splitlines()]
    assert lines[:2] == [["loads"], ["operation", "drill", "slide"]]
    assert lines[3:5] == [["hookload", "1.25", "2"], ["torque", "0.5", "3"]]


def test_names_and_values_have_no_headings():
    assert printed(Table((), [("scene", "pa6_bench")])).split() == ["scene", "pa6_bench"]


def test_markdown_escapes_pipes_and_keeps_a_row_on_one_line():
    assert Table(("a", Column("b", "N", right=True)), [("x|y\nz", 1.5), ("", None)]).markdown() == (
        "| a | b [N] |\n| --- | ---: |\n| x\\|y z | 1.5 |\n|  |  |"
    )


def test_csv_has_the_numbers_as_they_are():
    assert TABLE.csv() == "mark,radius [mm],motion\nbit|1,36.25,spiral\n\x1b[31mtop,,at <rest>\n"


def test_html_escapes_and_aligns():
    text = TABLE.html()
    assert '<tr><th class="name">mark</th><th class="number">radius [mm]</th><th>motion</th></tr></thead>' in text
    assert '<tr><th>bit|1</th><td class="number">36.25</td><td>spiral</td></tr>' in text
    assert "at &lt;rest&gt;" in text
    assert '<td class="name">bit|1</td>' in TABLE.html(named=False)
    assert Table((), [("a", "b")]).html() == "<table><tbody><tr><th>a</th><td>b</td></tr></tbody></table>"
