# SPDX-License-Identifier: Apache-2.0
"""Arguments of a scene's compiled functions: its formulation, the keys of its effects, their parameters."""

from types import ModuleType
from typing import Any

from drill_twin.dynamics.discretisation.drive import make_drive
from drill_twin.dynamics.discretisation.initial_state import axial_weight
from drill_twin.physics.effects import effect_module, with_variant
from drill_twin.physics.effects import parameters_of as effect_parameters
from drill_twin.physics.model.discrete_model import DiscreteModel
from drill_twin.scene import Scene

SPATIAL, LATERAL = "spatial", "lateral"


def form_of(scene: Scene) -> str:
    """Formulation of a scene: `LATERAL` with neither stretch nor torsion, else `SPATIAL`."""
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
