# SPDX-License-Identifier: Apache-2.0
"""Answers on a string for people, tables and sentences: its modes, and its statics."""

import cmath
import math
from collections.abc import Iterator, Sequence

from drill_twin.core.table import Table
from drill_twin.core.units.system import UnitSystem
from drill_twin.dynamics.discretisation.notes import notes_on_rotors
from drill_twin.dynamics.rotordynamics.assembly import ABOVE, LEAN, MOVED, Assembly
from drill_twin.dynamics.rotordynamics.assembly_modes import critical_ranges, in_trough
from drill_twin.dynamics.rotordynamics.campbell import Campbell
from drill_twin.dynamics.rotordynamics.modes import Mode, ModeTable
from drill_twin.dynamics.torque_drag.analysis import Statics
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command
from drill_twin.studies.modes import critical_text, modes_table
from drill_twin.studies.statics import PART, loads_table, parts_of

NEAR_ROTATION = 0.05
"""Distance of a resonance from the rotation, over it, up to which it is marked: as far as critical speeds agree with
other beam elements (2 to 5 %)."""
SMALL = 1.0
"""Force of the wall below which a contact carries nothing [N], chosen."""
SHAPES = ("straight", "sinusoidal", "sinusoidal, helix", "helix")
"""Words for `BucklingState` in the columns of the table."""


def shown_modes(table: ModeTable, diagram: Campbell | None, scene: Scene) -> Iterator[Table | str]:
    """Tables of the modes and of their resonances, what the table leaves out, and critical speeds."""
    units, swings = scene.unit_system, [mode for mode in table.modes if in_trough(table, mode)]
    own = [mode for mode in table.modes if not in_trough(table, mode)]
    yield modes_table(table, own)
    if swings:
        yield modes_table(table, swings, "swings of what lies on the wall, in the trough of the hole")
    yield from _sentences(table)
    yield from notes_on_rotors(scene)
    if table.assembly is not None:
        yield from _assembly(table, table.assembly, units)
        if (mud := scene.effects.added_mass) and not mud.confined:
            yield "mud moves as in open fluid; --set added_mass.confined=true (concentric gap) lowers critical speeds"
        yield _resonances(own, scene, table.balance.command)
    if scene.effects.viscous_drag is not None:
        yield (
            "mud: at rest around a string in the middle of the hole. Not in the model: mud that turns with the string, "
            "which can drive forward whirl slower than half the rotation, and the larger added mass near the wall, "
            "which lowers critical speeds"
        )
    if diagram is not None:
        yield f"critical speeds: {critical_text(diagram)}"


def _resonances(modes: Sequence[Mode], scene: Scene, command: Command) -> Table:
    """Rotations at which an excitation some times a revolution meets a mode: of the scene's bit, where it is known."""
    blocks = (getattr(scene.effects, key, None) for key in ("bit_regenerative", "bit_torque_stribeck", "rock_floor"))
    (rock, law, floor), turn, orders = blocks, abs(command.rotation), {1: "unbalance, bend"}
    kind = law and law.bit
    if rock is None and kind in {None, "roller_cone"}:
        orders[3] = "cones of a roller cone bit"
    if floor is not None and floor.lobe_height > 0.0:
        orders[round(floor.lobes)] = "lobes of the rock"
    if rock is not None:
        orders[rock.blades] = "blades of the bit"
    unknown = "" if rock or kind == "roller_cone" else "; blades: 1, over their number, which the scene does not give"

    def cell(speed: float) -> str:
        return scene.unit_system.number(speed, "rotation") + "*" * (abs(speed - turn) < NEAR_ROTATION * turn)

    rows = [
        (f"{mode.kind} {mode.number}", f"{abs(mode.frequency):.4g}",
         *(cell(abs(mode.eigenvalue.imag) / order) for order in sorted(orders)))
        for mode in modes
    ]  # fmt: skip
    named = "; ".join(f"{order}: {orders[order]}" for order in sorted(orders))
    return Table(
        ("mode", "Hz", *(f"{order} a turn" for order in sorted(orders))), rows, right=range(1, 2 + len(orders)),
        title=f"resonances: rotation in {scene.unit_system.rotation} at which an excitation of an order meets a mode "
        f"({named}{unknown}); *: within {NEAR_ROTATION:.0%} of the rotation",
    )  # fmt: skip


def _assembly(table: ModeTable, part: Assembly, units: UnitSystem) -> Iterator[str]:
    """Sentences on the extent of the assembly, its cut, and the critical speeds."""
    lateral, rotation = table.of("lateral"), abs(table.balance.command.rotation)
    for trough, what in ((False, "critical speeds"), (True, "critical speeds of swings in the trough")):
        ranges = critical_ranges(table, trough)
        named = ", ".join(
            units.number(first, "rotation")
            + (f" to {units.number(rest[-1], 'rotation')} ({1 + len(rest)} modes)" if rest else "")
            for first, *rest in ranges
        )
        if named and rotation > 0.0:
            away = min((speed / rotation - 1.0 for near in ranges for speed in near), key=abs)
            named += f"; the nearest is {abs(away):.1%} {'above' if away > 0.0 else 'below'} the rotation"
        place = f"the lowest {units.text(part.collars, 'length')}"
        yield f"{what} of {place}, up to twice the rotation, in {units.rotation}: {named or 'none'}"
    if others := [str(mode.number) for mode in lateral if not mode.of_collars]:
        yield f"lateral {', '.join(others)}: not counted, most energy is in the pipe above (near 50 %: in both)"
    moved = max((abs(mode.cut_change) / abs(mode.eigenvalue) for mode in lateral), default=0.0)
    yield (
        f"the pipe is cut {units.text(ABOVE, 'length')} above the assembly; with the cut at "
        f"{units.text(MOVED, 'length')} the modes listed change by at most {moved:.2%}; modes that change by more than "
        "1 % belong to the pipe and are not listed"
    )
    if part.leans:
        yield f"the hole is vertical: the string leans as at {math.degrees(LEAN):g} degree of inclination"


def _sentences(table: ModeTable) -> Iterator[str]:
    """Sentences on what the table leaves out, and where it was not compared with a finer mesh."""
    for kind, count in table.growing.items():
        shown = [mode for mode in table.of(kind) if mode.growth > 0.0]
        if count > len(shown):
            yield f"{count} {kind} modes grow; the table has {len(shown)} of them, among them the fastest"
    for kind, decay in table.creeping.items():
        yield (
            f"{kind}: motions that decay without oscillation (0 Hz, damping ratio 1), the slowest at {decay:.4g} 1/s, "
            "are not listed"
        )
    if math.isfinite(table.reach):
        kinds = "torsional and axial " if table.assembly else ""
        yield (
            f"of this large string {kinds}modes up to {table.reach / math.tau:.3g} Hz are computed: whether a faster "
            "motion grows is not known"
        )
    if any(cmath.isnan(mode.change) for mode in table.modes):
        yield "+- ?: not compared with another mesh"


def shown_statics(found: Statics) -> Iterator[Table | str]:
    """Loads, margins, contacts and parts of each operation."""
    operations, u = found.operations, found.scene.unit_system
    yield loads_table(found)
    yield from found.notes.values()
    yield Table(
        ("operation", "sinusoidal", "helix", "lock-up", "yield", "make-up", "stress", "shape"),
        [
            (
                loads.operation.name, *(_ratio(margin) for margin in loads.margins),
                _ratio(loads.lock_up / loads.operation.weight_on_bit if loads.operation.is_on_bottom else math.nan),
                _ratio(loads.yield_margin), _ratio(loads.make_up_margin),
                f"{u.show(float(loads.along.stress.max()), 'stress'):.4g}", SHAPES[loads.worst_state],
            )
            for loads in operations
        ],
        title=f"margins: limit over load where least, below 1 it is passed; largest stress in {u.stress}",
        right=range(1, 8),
    )  # fmt: skip
    if bent := [loads for loads in operations if loads.worst_state and loads.along.side_force.max() < 1e-6]:
        yield (
            f"{', '.join(loads.operation.name for loads in bent)}: past a buckling load, but in balance on the axis: "
            "hookload, stress and yield hold for straight pipe, without its bend and the friction of a helix"
        )
    yield Table(
        ("operation", *(contact.name for contact in operations[0].contacts)),
        [
            (
                loads.operation.name,
                *(f"{u.show(c.force, 'force'):.3g}, {math.degrees(c.tilt):.2f}" for c in loads.contacts),
            )
            for loads in operations
        ],
        title=f"force of the wall on bit and stabilisers in {u.force}, tilt against the hole in deg",
        right=range(1, 1 + len(operations[0].contacts)),
    )  # fmt: skip
    bits = [(loads.operation.name, loads.contacts[0]) for loads in operations]
    if math.isfinite(bits[0][1].build):
        yield Table(
            ("operation", "build +, drop -", "right +, left -", "tilt, up +"),
            [
                (name, *(f"{round(float(value), 3) + 0.0:+.3f}" for value in (
                    u.show(bit.build, "force"), u.show(bit.walk, "force"), math.degrees(bit.lift))))
                for name, bit in bits
            ],
            title=f"force of the bit on the hole in {u.force}, tilt in deg; what it cuts sideways is not computed",
            right=range(1, 4),
        )  # fmt: skip
    elif len(operations[0].contacts) > 1 and max(one.force for loads in operations for one in loads.contacts) < SMALL:
        yield (
            "forces of bit and stabilisers are 0, as the hole is vertical and nothing presses them to the wall; a "
            "survey with the inclination of the real hole, be it 0.5 deg, shows them"
        )
    last, kinds = operations[-1], [kind for _, _, kind in PART]
    yield Table(
        ("part", *(word for word, _, _ in PART)),
        [
            (name, *(f"{u.show(value, kind) if kind else 100.0 * value:.4g}"
                     for value, kind in zip(values.tolist(), kinds, strict=True)))
            for name, values in parts_of(found.scene, last)
        ],
        title=f"{last.operation.name}: lower end of each part in {u.length}, tension in {u.force} and torque in "
        f"{u.torque} at its upper end, side force on all of it in {u.force}, share of it on the wall in %, largest "
        f"moment in {u.torque} and stress in {u.stress}",
        right=range(1, 8),
    )  # fmt: skip


def _ratio(margin: float) -> str:
    if not math.isfinite(margin):
        return "-"
    return f"{margin:.3g}" if margin < 1000.0 else "> 1000"
