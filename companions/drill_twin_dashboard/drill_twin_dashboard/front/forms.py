# SPDX-License-Identifier: Apache-2.0
"""Forms of the page, made from what the commands declare."""

import math
from typing import Any

from drill_twin.cli.app import commands

COMMANDS = ("scene new", "run", "statics", "modes", "whirl", "map", "compare", "report", "analyze", "watch")
"""Commands with a form."""
FIRST = (
    "--survey --tally --hole --casing --bit --mud --wob --rpm --units --duration --report --repeats --runs --campbell"
)
"""Options that a form shows at once; its others are folded away."""
LEFT_OUT = "--help --json --replace --dask --port --host --allow-host --no-browser --foxglove"
"""Options without an entry: what the page decides, output for programs, and what overwrites, or calls elsewhere."""

Form = dict[str, Any]
"""Help of a command, metavar and help of its argument (`target`), and entries of its options by name (`fields`)."""


def forms() -> dict[str, Form]:
    """Form of each command; of a command whose package is not installed, a form with a scene alone.

    Such a command, when it runs, says which package to install.
    """
    declared = {name.partition(" ")[2]: command for name, command in commands()}
    missing = {"help": "", "target": "SCENE", "target_help": "", "fields": {}}
    return {name: _form(declared[name]) if name in declared else missing for name in COMMANDS}


def _form(command: Any) -> Form:
    target = next(item for item in command.params if item.param_type_name == "argument")
    fields = [_field(item) for item in command.params if item.param_type_name == "option"]
    return {
        "help": command.help.partition("\n")[0],
        "target": target.metavar.strip("[]"),
        "target_help": target.help,
        "fields": {field["name"]: field for field in fields if field["name"] not in LEFT_OUT.split()},
    }


def _field(option: Any) -> dict[str, Any]:
    """Entry of an option: `name` of the flag that changes the default, and `kind`, the HTML element that suits it."""
    default = option.show_default if isinstance(option.show_default, str) else option.default
    metavar = option.metavar or ""
    kinds = {"flag": option.is_flag, "table": metavar == "CSV", "choice": "|" in metavar, "list": option.multiple}
    name = [*option.opts, *(option.secondary_opts if option.default is True else [])][-1]
    return {
        "name": name,
        "metavar": metavar,
        "help": option.help or "",
        "default": "" if isinstance(default, bool) or default in (None, [], math.inf, -math.inf) else str(default),
        "kind": next((kind for kind, holds in kinds.items() if holds), "text"),
        "first": option.required or name in FIRST.split(),
    }
