# SPDX-License-Identifier: Apache-2.0
"""Commands of `drill-twin`: arguments, options, defaults."""

import re
from typing import Any

from _printed.markdown import code, table
from drill_twin.cli import app as tree


def commands() -> str:
    """A section for each command, in the order of the help."""
    return "\n".join(_command(name, command) for name, command in tree.commands())


def _command(name: str, command: Any) -> str:
    arguments = [item for item in command.params if item.param_type_name == "argument"]
    options = [item for item in command.params if item.param_type_name == "option" and not item.hidden]
    usage = " ".join([name, *(_usage(item) for item in arguments), *(["[OPTIONS]"] if options else [])])
    lines = [f"## {name}", "", _plain(command.help or ""), "", "```text", usage, "```", ""]
    rows = [(code(_usage(item)), _plain(item.help or ""), "") for item in arguments]
    rows += [(_names(item), _plain(item.help or ""), _default(item)) for item in options if item.name != "help"]
    return "\n".join([*lines, table(("argument or option", "meaning", "default"), rows) if rows else ""])


def _usage(argument: Any) -> str:
    name = argument.metavar or argument.name.upper()
    return name if argument.required else f"[{name}]"


def _names(option: Any) -> str:
    names = ", ".join(code(name) for name in (*option.opts, *option.secondary_opts))
    return f"{names} {code(option.metavar)}" if option.metavar and not option.is_flag else names


def _default(option: Any) -> str:
    shown = option.show_default if isinstance(option.show_default, str) else option.default
    if shown in (None, "", False, [], ()) or callable(shown):
        return ""
    return code(str(shown).lower() if isinstance(shown, bool) else str(shown))


def _plain(text: str) -> str:
    """Text without the console's markup; each paragraph on a line."""
    return re.sub(r"\[/?(?:bold|dim|italic)?\]", "", text.replace("\b", "")).strip()
