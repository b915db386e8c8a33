# SPDX-License-Identifier: Apache-2.0
"""Arguments of the compiled functions of a scene: discrete model, formulation, effects and drive, empty arrays."""

import math
from types import ModuleType
from typing import Any

import numpy as np

from drill_twin.dynamics.discretisation.discretise import BoundaryConditions, axial_weight, discretise
from drill_twin.dynamics.discretisation.joint import joined_workspace, joint_of
from drill_twin.dynamics.discretisation.resolution import mesh, resolution_of
from drill_twin.dynamics.solver.boundary import AIM, PLACE, STEADY, Drive
from drill_twin.dynamics.solver.lateral.linear_solver import make_workspace as make_lateral_workspace
from drill_twin.dynamics.solver.spatial.linear_solver import make_workspace
from drill_twin.dynamics.solver.state import make_state
from drill_twin.physics.effects import PARTS, Effect, effect_module, parameters_of
from drill_twin.physics.model import Rod
from drill_twin.physics.model.bit import make_bit
from drill_twin.scene import Scene


def make_drive(scene: Scene, hanging: float) -> Drive:
    """Make the drive of a scene.

    Args:
        scene: The scene.
        hanging: Axial weight of the string [N].
    """
    top, block, weight = scene.rig.top_drive, scene.rig.block, scene.rig.first[0]
    from_top = scene.rig.weight_on_bit.at == "top"
    lines = 0.0 if block is None else block.stiffness
    driller = None if block is None else block.auto_driller
    tuning = top.tuning(*_torsion_of_the_string(scene))
    memory, bit = np.zeros(6), make_bit(weight + (hanging if from_top else 0.0))
    if block is not None:  # where the lines carry the string at the start
        memory, bit = np.zeros(13), make_bit(weight, 5, block.off_bottom)
        memory[PLACE] = (hanging - weight) / lines
    memory[AIM], memory[STEADY] = scene.rig.first[1], tuning.wait
    return Drive(
        from_top=1.0 if from_top else 0.0,
        hanging=hanging,
        driven=0.0 if top.model == "prescribed" else 1.0,
        proportional=tuning.proportional,
        integral=tuning.integral,
        limit=np.inf if top.torque_limit is None else top.torque_limit,
        inertia=top.inertia,
        damping=top.damping,
        memory=memory,
        bit=bit,
        lines=lines,
        rate=0.0 if driller is None else driller.rate,
        feed_gain=0.0 if driller is None else _compliance(scene, lines) / driller.response,
        feed_integral=0.0 if driller is None else 0.5 * _compliance(scene, lines) / driller.response**2,
        held_torque=np.inf if driller is None or driller.torque is None else driller.torque,
        spin_up=tuning.spin_up,
        wait=tuning.wait,
        cancelled=tuning.cancelled,
    )


def _compliance(scene: Scene, lines: float) -> float:
    """Compliance of drilling lines and string in series [m/N]."""
    return 1.0 / lines + sum(part.length / (part.youngs_modulus * part.area) for part in scene.string.sections)


def _torsion_of_the_string(scene: Scene) -> tuple[float, float]:
    """Impedance of the top section to torsional waves [N m s/rad], and first frequency of the string [rad/s].

    The string is held at the top and free at the bit: a mode has its node where the angle that the transfer matrices of
    the sections (Pestel and Leckie 1963) give at the top first is zero.
    """
    lines = [
        (2.0 * part.second_moment * np.sqrt(part.shear_modulus * part.density),
         part.length * np.sqrt(part.density / part.shear_modulus)) for part in scene.string.sections
    ]  # fmt: skip
    frequencies = np.geomspace(1e-9, 1.0, 20001) * math.tau / sum(delay for _, delay in lines)  # 0.1 % apart
    body = getattr(scene.effects, "bit_mass", None)
    angle, torque = np.ones_like(frequencies), frequencies**2 * (body.inertia if body else 0.0)
    for impedance, delay in lines:
        cosine, sine, size = np.cos(frequencies * delay), np.sin(frequencies * delay), impedance * frequencies
        angle, torque = angle * cosine - torque * sine / size, torque * cosine + angle * sine * size
    return float(lines[-1][0]), float(frequencies[np.argmax(angle <= 0.0)])


SPATIAL, LATERAL, JOINED = "spatial", "lateral", "joined"


def form_of(scene: Scene) -> str:
    """Formulation of a scene: `LATERAL` with neither stretch nor torsion, `JOINED` with a joint, else `SPATIAL`."""
    if joint_of(scene) is not None:
        return JOINED
    return LATERAL if scene.effects.stretch is None and scene.effects.torsion is None else SPATIAL


def effects_of(scene: Scene) -> tuple[Effect, ...]:
    """The effects with compiled functions, each with the variant that its block asks for, in the registry's order;
    discs and supports of the string after them.
    """
    kernels = (name for name in scene.effect_names if hasattr(effect_module(name), "Parameters"))
    parts = tuple(Effect(key) for key in PARTS if getattr(scene.string, key))
    return tuple(Effect.of(name, getattr(scene.effects, name)) for name in kernels) + parts


class KernelArguments:
    """Discrete model of a scene, with the arrays that its compiled equations take.

    Attributes:
        scene: The scene.
        model: Discrete model.
        boundary_conditions: Boundary conditions at bit and top.
        constrained: Mask of the constrained unknowns of bit and top, shape (2, 7).
        form: Formulation: "spatial", "joined" where the string moves laterally from a depth on only, or "lateral" for a
            scene with neither stretch nor torsion.
        hole: "straight" or "curved".
        effects: The effects in the kernel, in the order of their parameters.
    """

    def __init__(self, scene: Scene, rod: Rod | None = None) -> None:
        """Build the model, and arrays of zeros for the rest.

        Args:
            scene: The scene.
            rod: The meshed string; by default the scene's mesh, whose nodes depend on the scene's largest set-points.

        Raises:
            SceneError: The scene asks for an accuracy instead of elements and a step.
            TableError: Elements are to be chosen for a record that cannot be used.
        """
        self.scene, self.form, self.effects = scene, form_of(scene), effects_of(scene)
        self.model = discretise(scene, mesh(scene, resolution_of(scene)[0]) if rod is None else rod)
        self.hole = "straight" if self.model.wellbore.axis is None else "curved"
        self.boundary_conditions = BoundaryConditions.of(scene)
        self.constrained = self.boundary_conditions.constrained(scene.string.bit_end)
        count = self.rod.length.size
        loaded = count + 1 if any(effect.function("node_load") for effect in self.effects) else 0
        self._work: Any = make_lateral_workspace(count, loaded) if self.form == LATERAL else make_workspace(count)
        if self.form == JOINED:
            self._work = joined_workspace(scene, self.model, self.constrained, loaded)
        self._state = make_state(count)
        self._state.bit_frame[:] = self.model.bit_frame

    @property
    def rod(self) -> Rod:
        """The meshed string."""
        return self.model.rod

    def parameters_for(self, kernel: ModuleType, scene: Scene, *more: Any) -> Any:
        """Parameters of drive and effects of a scene as a generated module takes them, and `more` after them."""
        return kernel.Parameters(
            make_drive(scene, float(axial_weight(scene, self.model).sum())),
            *(
                parameters_of(key, getattr(scene.string if key in PARTS else scene.effects, key), self.model)
                for key, _ in self.effects
            ),
            *more,
        )
