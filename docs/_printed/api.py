# SPDX-License-Identifier: Apache-2.0
"""Public Python API: its names in tables, its docstrings in sections for autodoc, the keys of `summary.json`."""

from __future__ import annotations

import inspect
import re

import drill_twin
from _printed.markdown import code, table
from drill_twin.report.summary import summarise

SECTIONS = {
    "Scenes": ("drill_twin.api.scenes", "drill_twin.scene"),
    "Runs": ("drill_twin.api.simulation",),
    "Results": ("drill_twin.api.result",),
    "Analysis": ("drill_twin.api.whirl", "drill_twin.whirl"),
}
"""Titles of sections, and where their names are defined; others have the title of their module."""
_SERIES = [f"drill_twin.io.bag.series.{name}" for name in ("MarkSeries", "PoseSeries", "RigSeries", "CommandSeries")]
_OPTIONS = {
    "Scene": ("exclude-members: model_config, name, description, provenance",),
    "State": ("exclude-members: of",),
    "Result": ("inherited-members:", "exclude-members: recording"),
    "StoppedError": ("exclude-members: with_message, with_traceback, add_note",),
}


def api_names() -> str:
    """Tables of functions, classes and errors, each with the head of its docstring."""
    groups: dict[str, list[tuple[str, str]]] = {"Functions": [], "Classes": [], "Errors": []}
    for name in drill_twin.__all__:
        value = getattr(drill_twin, name)
        if isinstance(value, str):
            continue
        head = (inspect.getdoc(value) or "").partition("\n\n")[0]
        if not inspect.isclass(value):
            arguments = inspect.signature(value).parameters.values()
            signature = inspect.Signature([item.replace(annotation=item.empty) for item in arguments])
            text = re.sub(r"<function (?:<lambda>|(\w+)) at \w+>", lambda found: found[1] or "...", str(signature))
            groups["Functions"].append((code(f"{name}{text}"), head))
        else:
            groups["Errors" if issubclass(value, Exception) else "Classes"].append((code(name), head))
    return "\n".join(f"## {title}\n\n{table(('name', 'meaning'), rows)}" for title, rows in groups.items())


def summary_keys() -> str:
    """List of the keys of `summary.json`, from the docstring of the function that makes it."""
    returned = re.search(r"^Returns:\n(.*)\Z", inspect.getdoc(summarise) or "", re.MULTILINE | re.DOTALL)
    return inspect.cleandoc(returned[1]) + "\n" if returned else ""


def api() -> str:
    """A section for each group of names; the errors come last."""
    sections: dict[str, list[str]] = {title: [] for title in SECTIONS}
    errors = []
    for name in drill_twin.__all__:
        value = getattr(drill_twin, name)
        if inspect.isclass(value) and issubclass(value, Exception):
            errors.append(_directive("autoexception", name))
        elif not isinstance(value, str):
            kind = "autoclass" if inspect.isclass(value) else "autofunction"
            sections.setdefault(_title(value.__module__), []).append(_directive(kind, name))
    sections["Results"] += [f".. autoclass:: {name}" for name in _SERIES]
    sections["Errors"] = errors
    return "\n".join(
        f"## {title}\n\n```{{eval-rst}}\n{chr(10).join(lines)}\n```\n" for title, lines in sections.items()
    )


def _title(module: str) -> str:
    for title, places in SECTIONS.items():
        if any(module == place or module.startswith(f"{place}.") for place in places):
            return title
    return module.rpartition(".")[2].replace("_", " ").capitalize()


def _directive(kind: str, name: str) -> str:
    return "\n".join([f".. {kind}:: drill_twin.{name}", *(f"   :{option}" for option in _OPTIONS.get(name, ()))])
