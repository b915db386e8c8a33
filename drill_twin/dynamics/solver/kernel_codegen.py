# SPDX-License-Identifier: Apache-2.0
"""Generation of one compiled time loop for exactly the effects of a scene.

The loop is written once (`drill_twin.dynamics.solver.midpoint`) and takes the effects as functions. For a set of
effects a small module is generated that calls their functions in turn, and nothing else; numba compiles it and saves
the machine code beside it, under a name that changes with every source reached
(`drill_twin.core.compile.kernel_cache`). Numbers, tables and sections are arguments, so a change of them compiles
nothing.

An effect's module holds its block of the scene (`drill_twin.physics.effects.EffectConfig`), and may define any of the
following. Before the run:

* ``Parameters`` and ``parameters(block, model)``: what its functions take as ``parameters.<key>``, with arrays; where
  they are the fields of its block, ``Parameters = parameters_class(Block)`` is enough;
* ``initial_state(block, model, u, v)``: changes the state that the run begins with.

In the loop:

* ``distributed_load(parameters, rod, here, half_step, load, stiff)``: force per length on the string, at Gauss points;
* ``section_stress(parameters, rod, strain, half_step, resultants)``: bending and twist of the section;
* ``axial_damping(parameters, element, axial, rate)``: viscous axial force and its slope;
* ``end_load(parameters, rod, command, time, half_step, u, v, v_old, ends)``: forces at bit and top, as tangent and
  residual, shape (2, 7, 8);
* ``node_load(parameters, rod, time, half_step, u, v, v_old, nodes)``: forces at the nodes, as tangent and residual,
  shape (n + 1, 7, 8); rows and velocities are in space, in the lateral form with r'_z = 1;
* ``prescribed_motion(parameters, rod, time, trial)``: velocities of constrained unknowns at mid-step, where they are
  not zero;
* ``after_step(parameters, rod, command, time, step, u, v)``: update of an effect's own memory after a step;
* ``missed(parameters, v)``: share of dry friction at the bit by which the law differs at velocities from the tangent of
  the last iteration; Newton's method goes on where it is large;
* ``side_friction(parameters, here, along, across)``: in the joined form above the joint, in place of
  ``distributed_load``: force of the wall, friction along the hole, couple and their slopes;
* ``dissipated_power(parameters, here, half_step)``: for the energy audit, power per length turned into heat, where
  that is not all of the work of ``distributed_load``.

Where a block names a variant (`EffectConfig.variant`), ``distributed_load_<variant>`` is called in place of
``distributed_load``, and so on; what has no variant of its own is called as it is.
"""

from collections.abc import Sequence
from types import ModuleType

from drill_twin.core.compile import kernel_cache
from drill_twin.dynamics.solver.parameter_records import fields_read, record_name
from drill_twin.physics.effects import Effect, effect_module
from drill_twin.physics.effects.config import HOOKS

_RIG = {
    "end_load": "rig_end_load(parameters.drive, command, half_step, u, v, v_old, ends)",
    "after_step": "rig_after_step(parameters.drive, step, u, v)",
}
# Of the audited functions: first line, and the line after the call of each effect.
_BEGIN = {
    "section_stress": "energy_ledger.start_section(parameters.ledger.entries, strain, resultants)",
    "distributed_load": "energy_ledger.start_load(parameters.ledger.entries, load)",
    "node_load": "energy_ledger.start_nodes(parameters.ledger.entries, parameters.ledger.gauss, v, nodes)",
    "end_load": (
        "energy_ledger.record_ends("
        "parameters.ledger.entries, energy_ledger.WEIGHT_ON_BIT, energy_ledger.TOP_DRIVE, v, ends)"
    ),
}
_RECORD = {
    "axial_damping": "record_axial_damping({ledger}, {account}, element, added[0], rate)",
    "section_stress": "record_section({ledger}, {account}, strain, resultants)",
    "distributed_load": "record_load({ledger}, {account}, here, load)",
    "node_load": "record_nodes({ledger}, {account}, v, nodes)",
    "end_load": "record_ends(parameters.ledger.entries, {account}, {account}, v, ends)",
}
_LEDGER = "parameters.ledger.entries, parameters.ledger.gauss"


def packages_of(effects: Sequence[Effect]) -> tuple[str, ...]:
    """Top-level packages that the effects come from."""
    return tuple(sorted({effect_module(effect.key).__name__.partition(".")[0] for effect in effects}))


def import_line(key: str) -> str:
    """Import of an effect's module under its key in the scene."""
    package, _, module = effect_module(key).__name__.rpartition(".")
    source = f"from {package} import {module}" if package else f"import {module}"
    return source if module == key else f"{source} as {key}"


def call_of(effect: Effect, hook: str, arguments: str) -> str:
    """Call of an effect's function for a hook, with only the parameters that it reads; "" without such a function."""
    if not (function := effect.function(hook)):
        return ""
    fields = fields_read(getattr(effect_module(effect.key), function))
    if fields and (name := record_name(fields)):
        record = f"parameter_records.{name}({', '.join(f'parameters.{field}' for field in fields)})"
        arguments = record + arguments.removeprefix("parameters")
    return f"{effect.key}.{function}({arguments})"


def source(effects: Sequence[Effect], form: str, *, audit: bool = False) -> str:
    """The text of the module with the time loop for a set of effects and a form of the string."""
    more = "\nfrom drill_twin.dynamics.twin import frame_kernel, observation"
    more += "\nfrom drill_twin.dynamics.audit import energy_ledger, step_audit" if audit else ""
    fields = ["ledger: energy_ledger.EnergyLedger"] if audit else []
    contact = "wall.contact_force" if any(effect.key == "wall" for effect in effects) else None
    title = f"The {form} time loop for: {', '.join(map(str, effects)) or 'no effects'}"
    return f"""{_bound(effects, form, title, "midpoint", more, fields)}
{_audited(effects, form) if audit else "loop = midpoint.bind(form, effects)"}
frames = frame_kernel.bind(loop, observation.bind({contact}))


@entry_kernel
def run(words, kind, commands, seconds, step, table):
    return frames(words, kind, commands, seconds, step, table)
"""


def linearisation_source(effects: Sequence[Effect], form: str) -> str:
    """The text of the module with the equations at an instant (`drill_twin.dynamics.solver.linearisation`)."""
    title = f"The {form} equations at an instant for: {', '.join(map(str, effects)) or 'no effects'}"
    return f"""{_bound(effects, form, title, "linearisation", "", [])}
instant = linearisation.bind_{form}(form, effects)


@entry_kernel
def evaluate(parameters, rod, scratch, constrained, state, u, v, a, residual, tangents):
    instant(parameters, rod, scratch, constrained, state, u, v, a, residual, tangents)
"""


def _bound(effects: Sequence[Effect], form: str, title: str, solver: str, more: str, fields: Sequence[str]) -> str:
    """The part of a module that binds a formulation to the effects."""
    keys = [effect.key for effect in effects]
    imports = "\n".join(map(import_line, keys))
    own = [f"{key}: {key}.Parameters" for key in keys if hasattr(effect_module(key), "Parameters")]
    functions = "\n\n".join(_function(hook, effects) for hook in HOOKS)
    return f'''"""{title}. Generated by drill_twin; do not edit."""
from typing import NamedTuple

from drill_twin.core.compile.jit import entry_kernel, kernel
from drill_twin.dynamics.solver import {solver}, parameter_records
from drill_twin.dynamics.solver.boundary import Drive, rig_after_step, rig_end_load
from drill_twin.dynamics.solver.interface import Effects
from drill_twin.dynamics.solver.{form} import formulation{more}
{imports}


class Parameters(NamedTuple):
    {_lines(["drive: Drive", *own, *fields])}

{functions}


effects = Effects({", ".join(HOOKS)})
{_above(effects) if form == "joined" else ""}
form = {_bind(form)}'''


def _bind(form: str, *, audit: bool = False) -> str:
    """The binding of a form; the joined form also takes functions that act on a string that follows the hole."""
    bound = "audited" if audit else "effects"
    if form != "joined":
        return f"formulation.bind({bound})"
    prefix = "audited_above_" if audit else "above_"
    return f"formulation.bind({bound}, {prefix}section_stress, {prefix}distributed_load, {prefix}friction)"


def _above(effects: Sequence[Effect], *, audit: bool = False) -> str:
    """Functions of what acts on a string that follows the hole."""
    prefix, lines = "audited_" if audit else "", ["return across, 0.0, 0.0, 0.0, 0.0, 0.0"]
    for number, effect in enumerate(effects):
        if rub := call_of(effect, "side_friction", "parameters, here, along, across"):
            account = f"energy_ledger.FIRST_EFFECT + {number}"
            record = f"energy_ledger.record_side_friction({_LEDGER}, {account}, here, along, found)"
            lines = [f"found = {rub}", *([record] if audit else []), "return found"]
    functions = "\n\n".join(
        _function(hook, effects, audit=audit, above=True) for hook in ("section_stress", "distributed_load")
    )
    return f"""{functions}


@kernel
def {prefix}above_friction(parameters, here, along, across):
    {_lines(lines)}"""


def _audited(effects: Sequence[Effect], form: str) -> str:
    """The part of the module for the energy audit: the effects once more, each followed by a record of its work."""
    functions = "\n\n".join(_function(hook, effects, audit=True) for hook in _RECORD)
    functions += f"\n\n{_above(effects, audit=True)}" if form == "joined" else ""
    close = "step_audit.close_step" if form != "joined" else "midpoint.no_end"  # no effect shakes the top of that form
    replaced = ", ".join(f"{hook}=audited_{hook}" for hook in _RECORD)
    return f"""
{functions}


audited = effects._replace({replaced})
audit_step = step_audit.bind_{form}({_bind(form, audit=True)}.build)
loop = midpoint.bind(form, effects, audit_step, {close})"""


def _function(hook: str, effects: Sequence[Effect], *, audit: bool = False, above: bool = False) -> str:
    """A function that calls the effects' functions in turn; above a joint, none of an effect across the hole."""
    lines = [_RIG[hook]] if hook in _RIG else []
    called = hook != "node_load" or any(effect.function(hook) for effect in effects)
    lines += [_BEGIN[hook]] if audit and hook in _BEGIN and called else []
    damping = hook == "axial_damping"
    for number, effect in sorted(enumerate(effects), key=lambda pair: _comes_later(hook, pair[1])):
        if above and (effect.config.across or effect.function("side_friction")):
            continue
        account = f"energy_ledger.FIRST_EFFECT + {number}"
        if call := call_of(effect, hook, HOOKS[hook]):
            lines += [f"added = {call}", "force += added[0]", "slope += added[1]"] if damping else [call]
            lines[-1] = f"miss = max(miss, {call})" if hook == "missed" else lines[-1]
            lines += [f"energy_ledger.{_RECORD[hook].format(ledger=_LEDGER, account=account)}"] if audit else []
        heat = call_of(effect, "dissipated_power", "parameters, here, half_step")
        if audit and hook == "distributed_load" and heat:
            lines.append(f"energy_ledger.record_heat({_LEDGER}, {account}, here, {heat})")
    if damping:
        last = ["energy_ledger.next_sample(parameters.ledger.entries)"] if audit else []
        lines = ["force = 0.0", "slope = 0.0", *lines, *last, "return force, slope"]
    if hook == "missed":
        lines = ["miss = 0.0", *lines, "return miss"]
    return f"""
@kernel
def {"audited_" if audit else ""}{"above_" if above else ""}{hook}({HOOKS[hook]}):
    {_lines(lines or ["pass"])}"""


def _comes_later(hook: str, effect: Effect) -> bool:
    """True for an effect that is called after the weight on bit is found, which laws of torque read."""
    return hook == "end_load" and "weight" not in effect.config.provides


def _lines(lines: Sequence[str]) -> str:
    return "\n    ".join(lines)


def build_kernel(
    effects: tuple[Effect, ...], form: str = "spatial", hole: str = "straight", *, audit: bool = False
) -> ModuleType:
    """The module with ``run`` and ``Parameters`` for a set of effects, compiled on first use.

    Args:
        effects: In the order of the registry.
        form: "spatial", "joined" for a string that moves laterally from a depth on, or "lateral" for a string that
            neither stretches nor twists.
        hole: "straight" or "curved": it decides the types of the arguments, and a module holds the kernel for one.
        audit: Include the energy audit.
    """
    with kernel_cache.ONE_THREAD:
        text = source(effects, form, audit=audit)
        return kernel_cache.load_generated("kernel", text, hole, packages=packages_of(effects))


def build_linearisation(effects: tuple[Effect, ...], form: str, hole: str) -> ModuleType:
    """The module with ``evaluate`` and ``Parameters``: the equations at an instant; arguments as in `build_kernel`."""
    with kernel_cache.ONE_THREAD:
        text = linearisation_source(effects, form)
        return kernel_cache.load_generated("linear", text, hole, packages=packages_of(effects))
