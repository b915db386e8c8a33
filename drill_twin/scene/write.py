# SPDX-License-Identifier: Apache-2.0
"""YAML text of plain data."""

import re
from typing import Any

import yaml

_LINE_BREAKS_OF_UNICODE = re.compile("[\x85\u2028\u2029\ufeff]")


def yaml_text(data: dict[str, Any]) -> str:
    """YAML text that reads back to the same data: keys in order, UTF-8, Unicode line breaks escaped."""
    text: str = yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110)
    return text


class _Dumper(yaml.SafeDumper):
    """Safe dumper that escapes Unicode line breaks."""


def _represent(dumper: _Dumper, text: str) -> yaml.ScalarNode:
    style = '"' if _LINE_BREAKS_OF_UNICODE.search(text) else None
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _represent)
