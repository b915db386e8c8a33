# SPDX-License-Identifier: Apache-2.0
"""Files and functions that the pages name exist."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "drill_twin"
PAGES = (
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "QUALITY_DECLARATION.md",
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / "evidence" / "docs").glob("*.md")),
)
NAMED = re.compile(r"\b(?<!/)((?:drill_twin|companions|test|config|evidence)/[\w/.-]*\w)")
LINKED = re.compile(r"\]\(([^)#\s:]*)(?:#([^)\s]*))?\)")


def _anchors(page):
    """Anchors of the headings of a page, as GitHub makes them."""
    titles = re.findall(r"^#+ (.*)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_files_that_a_page_names_exist(page):
    text = page.read_text("utf-8")
    # A node or an enclave is named drill_twin/NAME too, with a slash before it.
    named = [name for name in NAMED.findall(text.replace("/drill_twin/", "")) if "NAME" not in name]
    missing = [name for name in named if not (ROOT / name).exists()]
    assert not missing
    links = [(page.parent / path if path else page, anchor) for path, anchor in LINKED.findall(text)]
    assert not [str(file) for file, _ in links if not file.exists()]
    assert not [anchor for file, anchor in links if anchor and anchor not in _anchors(file)]


def _rows():
    """File cells and function cells of the table of the way from weight on bit to onset, a pair for each row."""
    text = (ROOT / "docs" / "design.md").read_text("utf-8")
    table = text.partition("## From weight on bit to the onset of whirl")[2].partition("\n## ")[0]
    for line in table.splitlines():
        cells = line.strip("| ").split(" | ")
        if len(cells) == 3 and cells[0] != "step" and not cells[0].startswith("-"):
            yield cells[1], cells[2]


def _files(cell):
    """Paths in a cell; one without a folder lies in that of the path before it."""
    folder = Path()
    for name in re.findall(r"`([\w/]+\.py)`", cell):
        direct = folder / name
        path = direct if (PACKAGE / direct).exists() else Path(name)
        folder = path.parent
        yield path


ROWS = list(_rows())


def test_the_way_has_both_ends():
    assert "`/rig/wob_command`" in (ROOT / "docs" / "design.md").read_text("utf-8")
    assert len(ROWS) > 15


@pytest.mark.parametrize(("files", "functions"), ROWS, ids=[files.split("`")[1] for files, _ in ROWS])
def test_the_way_names_functions_that_exist(files, functions):
    paths = [*_files(files), *_files(files + functions)]
    defined = set()
    for path in paths:
        for node in ast.walk(ast.parse((PACKAGE / path).read_text("utf-8"))):
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                defined.add(node.name)
            elif isinstance(node, ast.AnnAssign | ast.Assign):  # attributes
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                defined |= {target.attr for target in targets if isinstance(target, ast.Attribute)}
    named = [word for name in re.findall(r"`([\w.]+)`", functions) if not name.endswith(".py")
             for word in name.split(".") if word]  # fmt: skip
    assert named
    assert set(named) <= defined


def test_paths_of_the_table_where_to_go_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    table = text.partition("## Where to go for")[2].partition("\n## ")[0]
    names = [name for name in re.findall(r"`([a-z_]+/[\w/.]*)`", table) if "NAME" not in name]
    assert len(names) > 20
    missing = [name for name in names if not ((PACKAGE / name).exists() or (ROOT / name).exists())]
    assert not missing


def test_the_readme_is_read_in_one_sitting():
    assert len((ROOT / "README.md").read_text("utf-8").splitlines()) <= 120
