# SPDX-License-Identifier: Apache-2.0
"""Configuration of the documentation site: `make docs` builds it with Sphinx into out/docs/html."""

import re
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

import _printed  # noqa: E402 - the two paths above come first
import style  # noqa: E402

import drill_twin  # noqa: E402

project, author, copyright = "drill_twin", "The drill_twin contributors", "The drill_twin contributors, Apache-2.0"  # noqa: A001
version = release = drill_twin.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["examples", "_printed", "static"]
html_theme = "furo"
html_title = f"drill_twin {release}"
html_theme_options = {"source_repository": "", "navigation_with_keys": True}
html_show_sphinx = False
html_static_path, html_css_files = ["static"], ["site.css"]
html_copy_source = False
html_math_renderer = "mathml"  # drawn by the browser itself: the site opens without a network

# Markdown as GitHub reads it: headings are link targets.
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]

# Docstrings are Google style; a word in single backquotes is code.
default_role = "literal"
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_default_options = {"members": True, "exclude-members": "model_config"}
napoleon_attr_annotations = False
napoleon_use_ivar = True  # attributes in a docstring are not declared a second time
# Types of the standard library, numpy and internal modules have no page here; no inventory is fetched.
nitpick_ignore_regex = [("py:.*", r"(?!drill_twin\.[A-Za-z_]+$).*")]


_LOG = logging.getLogger(__name__)
_PRINTED = re.compile(r"^<!-- printed: (\w+) -->$(?!.*?^<!-- end: \1 -->$)", re.MULTILINE | re.DOTALL)


def _check_style(_app: Sphinx, page: str, source: list[str]) -> None:
    """Warn of each fault of style that a page has, which ends `make docs`."""
    for line, fault in style.faults(source[0]):
        _LOG.warning("%s", fault, location=(page, line), type="style")


def _insert_printed(_app: Sphinx, _page: str, source: list[str]) -> None:
    """Put what the code prints in place of each line `<!-- printed: NAME -->` whose part is not committed."""
    source[0] = _PRINTED.sub(lambda found: _printed.PAGES[found[1]](), source[0])


def _no_type_in_the_text(
    _app: Sphinx, what: str, _name: str, _object: object, _options: object, lines: list[str]
) -> None:
    """Keep napoleon from reading the text before the first colon of an attribute's docstring as its type."""
    if what in {"attribute", "data", "property"}:
        lines[:0] = ["..", ""]  # an empty comment: a first line without a colon


def _formula(page: Any, node: nodes.math) -> None:
    """Write a formula in a line as MathML."""
    page.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def _formula_apart(page: Any, node: nodes.math_block) -> None:
    """Write a formula in a paragraph of its own as MathML."""
    page.body.append(tex2mathml(node.astext(), as_block=True))
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Connect the printed parts, formulas as MathML, and a filter of docstrings that comes before napoleon."""
    app.add_html_math_renderer("mathml", (_formula, None), (_formula_apart, None))
    app.connect("source-read", _check_style, priority=400)
    app.connect("source-read", _insert_printed)
    app.connect("autodoc-process-docstring", _no_type_in_the_text, priority=400)
