# SPDX-License-Identifier: Apache-2.0
"""Arguments of the compiled functions of a scene: its formulation, keys and parameters of its effects, its drive."""

from types import ModuleType
from typing import Any

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.discretisation.discretise import axial_weight
from drill_twin.dynamics.discretisation.joint import joint_of
from drill_twin.dynamics.solver.boundary import PLACE, Drive
from drill_twin.physics.effects import effect_module, with_variant
from drill_twin.physics.effects import parameters_of as effect_parameters
from drill_twin.physics.model.bit import make_bit
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.scene import Scene


def make_drive(scene: Scene, hanging: float) -> Drive:
    """Make the drive of a scene.

    Args:
        scene: The scene.
        hanging: Axial weight of the string [N].
    """
    top = scene.rig.top_drive
    from_top = scene.rig.weight_on_bit.at == "top"
    block = scene.rig.block
    lines = 0.0 if block is None else block.stiffness
    driller = None if block is None else block.auto_driller
    proportional, integral = top.gains(*_torsion_of_the_string(scene))
    return Drive(
        from_top=1.0 if from_top else 0.0,
        hanging=hanging,
        driven=0.0 if top.model == "prescribed" else 1.0,
        proportional=proportional,
        integral=integral,
        limit=np.inf if top.torque_limit is None else top.torque_limit,
        inertia=top.inertia,
        damping=top.damping,
        memory=np.zeros(4) if block is None else _memory((hanging - scene.rig.first[0]) / lines),
        bit=(
            make_bit(scene.rig.first[0] + (hanging if from_top else 0.0))
            if block is None
            else make_bit(scene.rig.first[0], 5, block.off_bottom)
        ),
        lines=lines,
        rate=0.0 if driller is None else driller.rate,
        feed_gain=0.0 if driller is None else _compliance(scene, lines) / driller.response,
        feed_integral=0.0 if driller is None else 0.5 * _compliance(scene, lines) / driller.response**2,
        held_torque=np.inf if driller is None or driller.torque is None else driller.torque,
    )


def _memory(place: float) -> Array:
    """Memory with the block where its lines carry the string at the start [m]."""
    memory = np.zeros(11)
    memory[PLACE] = place
    return memory


def _compliance(scene: Scene, lines: float) -> float:
    """Compliance of drilling lines and string in series [m/N]."""
    return 1.0 / lines + sum(part.length / (part.youngs_modulus * part.area) for part in scene.string.sections)


def _torsion_of_the_string(scene: Scene) -> tuple[float, float]:
    """Impedance of the top section to torsional waves [N m s/rad], time of such a wave from top to bit [s]."""
    top = scene.string.sections[-1]
    impedance = 2.0 * top.second_moment * np.sqrt(top.shear_modulus * top.density)
    delay = sum(part.length * np.sqrt(part.density / part.shear_modulus) for part in scene.string.sections)
    return float(impedance), float(delay)


SPATIAL, LATERAL, JOINED = "spatial", "lateral", "joined"


def form_of(scene: Scene) -> str:
    """Formulation of a scene: `LATERAL` with neither stretch nor torsion, `JOINED` with a joint, else `SPATIAL`."""
    if joint_of(scene) is not None:
        return JOINED
    return LATERAL if scene.effects.stretch is None and scene.effects.torsion is None else SPATIAL


def effects_of(scene: Scene) -> tuple[str, ...]:
    """Keys of the effects with compiled functions, in the order of the registry."""
    return tuple(name for name in scene.effect_names if hasattr(effect_module(name), "Parameters"))


def variants_of(scene: Scene) -> tuple[str, ...]:
    """The same keys, each with the variant that its block asks for: what a kernel is generated from."""
    return tuple(with_variant(name, getattr(scene.effects, name)) for name in effects_of(scene))


def parameters_of(kernel: ModuleType, scene: Scene, model: DiscreteModel, *more: Any) -> Any:
    """Parameters of drive and effects as a generated module takes them, and `more` after them."""
    return kernel.Parameters(
        make_drive(scene, float(axial_weight(scene, model).sum())),
        *(effect_parameters(name, getattr(scene.effects, name), model) for name in effects_of(scene)),
        *more,
    )
