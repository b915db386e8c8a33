# SPDX-License-Identifier: Apache-2.0
"""One compiled time loop for exactly the effects of a scene.

The loop is written once (`drill_twin.solve.midpoint`) and takes the effects as functions. For a set of effects a small
module is written that calls their functions in turn, and nothing else; numba compiles it and keeps the machine code
beside it. The module's name is a hash of every source it is built from, of the versions and of the processor, so stale
code cannot be met: an edit makes another name. Numbers, tables and sections are arguments, so they never compile.

An effect's file holds its block (`drill_twin.effects.Block`), and may define any of the following. Before the run:

* ``Parameters`` and ``parameters(block, site)``: what its functions take as ``parameters.<key>``, arrays included;
* ``start(block, site, u, v)``: changes the state that the run begins with.

In the loop, which calls those that exist:

* ``point(parameters, rod, here, h2, load, stiff)``: force per length on the string, at the Gauss points;
* ``section(parameters, rod, strain, h2, resultants)``: bending and twist of the section;
* ``stretch(parameters, element, axial, rate)``: viscous axial force and its slope;
* ``end(parameters, rod, command, time, h2, u, v, v_old, ends)``: forces at the bit and the top, as tangent and
  residual, shape (2, 7, 8);
* ``guide(parameters, rod, time, trial)``: velocities of held unknowns at mid-step, where they are not zero;
* ``done(parameters, rod, command, time, step, u, v)``: after a step was taken, for effects that remember something;
* ``lost(parameters, here, h2)``: for the audit, power per length turned into heat, where it is not all of the work.
"""

from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import cast

from drill_twin.solve import keep

_FORMS = {
    "spatial": ("solve.work", "solve.spatial", "solve.assembly", "solve.blocks"),
    "lateral": ("solve.lateral", "solve.lateral_assembly", "solve.lateral_blocks"),
}
HOOKS = ("point", "section", "stretch", "end", "guide", "done")
_SOURCES = (
    "rod.jit", "rod.types", "rod.point", "rod.hole", "rod.bit", "rod.mesh", "rod.section", "rod.stretch",
    "solve.state", "solve.bit_frame", "solve.drive", "solve.midpoint", "solve.compose", "solve.keep",
)  # fmt: skip


def effect_module(name: str) -> ModuleType:
    """The module of an effect, by its key in the scene."""
    return import_module(f"drill_twin.effects.{name}")


def fingerprint(effects: tuple[str, ...], form: str, hole: str, *, audit: bool = False) -> str:
    """Hash of all that decides the machine code: sources, kind of hole, versions, processor."""
    own = ("solve.audit",) if audit else ()
    return keep.fingerprint((*_SOURCES, *own, *_FORMS[form], *(f"effects.{name}" for name in effects)), hole)


def source(effects: tuple[str, ...], form: str, *, audit: bool = False) -> str:
    """The text of the module for a set of effects and a form of the string."""

    def calls(hook: str, line: str) -> str:
        names = [name for name in effects if hasattr(effect_module(name), hook)]
        return "\n".join("    " + line.format(name=name) for name in names) or "    pass"

    imports = "\n".join(f"from drill_twin.effects import {name}" for name in effects)
    fields = "\n".join(
        f"    {name}: {name}.Parameters" for name in effects if hasattr(effect_module(name), "Parameters")
    )
    return f'''"""The {form} time loop for: {", ".join(effects) or "no effects"}. Written by drill_twin; do not edit."""
from typing import NamedTuple

from numba import njit

from drill_twin.rod.jit import FLAGS
from drill_twin.solve.drive import Drive, rig_done, rig_ends
from drill_twin.solve import {"audit, " if audit else ""}midpoint, {form}
{imports}


class Parameters(NamedTuple):
    drive: Drive
{fields}
{"    ledger: audit.Ledger" if audit else ""}


@njit(**FLAGS)
def stretch_effects(parameters, element, axial, rate):
    force = 0.0
    slope = 0.0
{calls("stretch", "more = {name}.stretch(parameters, element, axial, rate); force += more[0]; slope += more[1]")}
    return force, slope


@njit(**FLAGS)
def section_effects(parameters, rod, strain, h2, resultants):
{calls("section", "{name}.section(parameters, rod, strain, h2, resultants)")}


@njit(**FLAGS)
def point_effects(parameters, rod, here, h2, load, stiff):
{calls("point", "{name}.point(parameters, rod, here, h2, load, stiff)")}


@njit(**FLAGS)
def end_effects(parameters, rod, command, time, h2, u, v, v_old, ends):
    rig_ends(parameters.drive, command, h2, u, v, v_old, ends)
{calls("end", "{name}.end(parameters, rod, command, time, h2, u, v, v_old, ends)")}


@njit(**FLAGS)
def guide_effects(parameters, rod, time, trial):
{calls("guide", "{name}.guide(parameters, rod, time, trial)")}


@njit(**FLAGS)
def done_effects(parameters, rod, command, time, step, u, v):
    rig_done(parameters.drive, step, u, v)
{calls("done", "{name}.done(parameters, rod, command, time, step, u, v)")}


effects = midpoint.Effects(
    stretch_effects, section_effects, point_effects, end_effects, guide_effects, done_effects
)
moves = {form}.bind(effects)
{_books(effects, form) if audit else "loop = midpoint.bind(moves, effects)"}


@njit(cache=True, **FLAGS)
def advance(parameters, rod, work, fixed, state, limits, command0, command1, start, end, counters):
    return loop(parameters, rod, work, fixed, state, limits, command0, command1, start, end, counters)
'''


def _books(effects: tuple[str, ...], form: str) -> str:
    """The part of the module that keeps books: the effects once more, each followed by what it has done."""
    books = "parameters.ledger.books, parameters.ledger.course"

    def calls(hook: str, line: str, book: str) -> str:
        lines = []
        for account, name in enumerate(effects, 4):  # drill_twin.solve.audit.EFFECTS
            module = effect_module(name)
            if hasattr(module, hook):
                lines += [line.format(name=name), f"audit.{book}".format(account=account, books=books)]
            if hook == "point" and hasattr(module, "lost"):
                lines += [f"audit.book_heat({books}, {account}, here, {name}.lost(parameters, here, h2))"]
        return "\n".join(f"    {text}" for text in lines) or "    pass"

    return f"""

@njit(**FLAGS)
def stretch_books(parameters, element, axial, rate):
    force = 0.0
    slope = 0.0
{
        calls(
            "stretch",
            "more = {name}.stretch(parameters, element, axial, rate); force += more[0]; slope += more[1]",
            "book_stretch({books}, {account}, element, more[0], rate)",
        )
    }
    audit.next_sample(parameters.ledger.books)
    return force, slope


@njit(**FLAGS)
def section_books(parameters, rod, strain, h2, resultants):
    audit.open_section(parameters.ledger.books, strain, resultants)
{
        calls(
            "section",
            "{name}.section(parameters, rod, strain, h2, resultants)",
            "book_section({books}, {account}, strain, resultants)",
        )
    }


@njit(**FLAGS)
def point_books(parameters, rod, here, h2, load, stiff):
    audit.open_load(parameters.ledger.books, load)
{
        calls(
            "point",
            "{name}.point(parameters, rod, here, h2, load, stiff)",
            "book_load({books}, {account}, here, load)",
        )
    }


@njit(**FLAGS)
def end_books(parameters, rod, command, time, h2, u, v, v_old, ends):
    rig_ends(parameters.drive, command, h2, u, v, v_old, ends)
    audit.book_ends(parameters.ledger.books, audit.WEIGHT, audit.DRIVE, v, ends)
{
        calls(
            "end",
            "{name}.end(parameters, rod, command, time, h2, u, v, v_old, ends)",
            "book_ends(parameters.ledger.books, {account}, {account}, v, ends)",
        )
    }


books = effects._replace(stretch=stretch_books, section=section_books, point=point_books, end=end_books)
keep_books = audit.bind_{form}({form}.bind(books).build)
loop = midpoint.bind(moves, effects, keep_books, audit.settle)
"""


def entry(module: ModuleType) -> Callable[..., int]:
    """``advance`` of a composed module; call it once with real arguments before.

    Past numba's dispatcher: with a second kernel in the process that takes 0.4 ms a call to find out again what the
    types are, more than a frame's motion.
    """
    compiled = list(module.advance.overloads.values())
    return cast("Callable[..., int]", compiled[0].entry_point if len(compiled) == 1 else module.advance)


def compose(
    effects: tuple[str, ...], form: str = "spatial", hole: str = "straight", *, audit: bool = False
) -> ModuleType:
    """The module with ``advance`` and ``Parameters`` for a set of effects, compiled on first use.

    Args:
        effects: Scene keys in the order of the registry.
        form: "spatial", or "lateral" for a string that neither stretches nor twists.
        hole: "straight" or "curved": the types of the arguments decide what is compiled, and a module holds one kernel.
        audit: Whether it keeps books of energy; without, nothing of that is compiled.
    """
    name = f"drill_twin_kernel_{fingerprint(effects, form, hole, audit=audit)}"
    return keep.kept(name, source(effects, form, audit=audit))
