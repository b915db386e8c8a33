# SPDX-License-Identifier: Apache-2.0
"""Imbalance: response through resonance, the work of the drive, and where the mass centres lie."""

from typing import Any

import numpy as np
import pytest
from hole_scenes import bend, with_parts
from rod_scenes import LINE_MASS, WALLED, quiet_scene

from drill_twin.dynamics.audit.energy import energy
from drill_twin.dynamics.twin.twin import Twin
from drill_twin.physics.effects.eccentricity import Eccentricity, offsets, parameters
from drill_twin.physics.model import element_unknowns
from drill_twin.scene import Scene
from drill_twin.scene.set_points.command import Command

OFFSET, ANGLE, DRAG = 1e-3, -0.4, 0.25


@pytest.mark.parametrize("hole", [None, bend(4.0, 5.0, hole=0.3)], ids=["straight", "curved"])
def test_the_drive_pays_for_the_motion(hole: dict[str, Any] | None) -> None:
    """Spun up with its mass centre off the line, the rod holds as much energy as the drive has given."""
    scene = quiet_scene({"eccentricity": {"offset": 5e-3}}, of=WALLED, step=1e-3, elements=16, frame_rate=1000.0)
    if hole is not None:
        scene = Scene.model_validate(scene.model_dump(exclude_none=True) | {"hole": hole})
    twin = Twin(scene)
    rod, (u, v) = twin.rod, twin.unknowns
    law = parameters(scene.effects.eccentricity, twin.model)
    weight = 0.5 * rod.length[:, None]
    start = energy(rod, u, v).total

    def held() -> float:
        velocity = np.einsum("epi,eic->epc", rod.shape[:, :, 0], element_unknowns(v))
        spin, rate = (np.stack([rows[:-1, 6], rows[1:, 6]], -1) @ rod.spin_shape.T for rows in (u, v))
        zero, quarter = np.moveaxis(law.imbalance.reshape(*spin.shape, 2, 3), 2, 0)
        turned = np.cos(spin)[..., None] * quarter - np.sin(spin)[..., None] * zero
        across, inertia = np.sum(velocity * turned, axis=-1), law.inertia.reshape(spin.shape)
        return energy(rod, u, v).total - start + float(np.sum(weight * rate * (across + 0.5 * inertia * rate)))

    given, before, most = 0.0, 0.0, 0.0
    for k in range(2000):
        speed = 10.0 * min((k + 1) * 1e-3, 1.0)
        torque = twin.advance(Command(weight_on_bit=0.0, rotation=speed), 1e-3).rig.top_drive_torque
        given += torque * 0.5 * (before + speed) * 1e-3
        before, most = speed, max(most, held())
        assert held() == pytest.approx(given, abs=1e-4 * max(most, 1e-4) + 1e-6 * start)
    assert energy(rod, u, v).total - start != pytest.approx(given, rel=1e-2), "the mass centre's part must matter"


def test_mass_centres_lie_across_the_hole() -> None:
    """In a hole that builds by 72 degrees the mass centre turns about the axis of the hole, right-handed."""
    twin = Twin(with_parts(hole=bend(4.0, 5.0), effects={}))
    law = parameters(Eccentricity(offset=1e-3, angle=0.3), twin.model)
    axis = twin.model.wellbore.axis
    assert axis is not None
    zero, quarter = law.imbalance[:, 0], law.imbalance[:, 1]
    assert np.linalg.norm(zero, axis=1) == pytest.approx(np.full(len(zero), LINE_MASS * 1e-3))
    assert np.sum(zero * axis.tangent, axis=1) == pytest.approx(0.0, abs=1e-12)
    assert np.cross(axis.tangent, zero) == pytest.approx(quarter, abs=1e-12)


def test_each_section_has_its_own() -> None:
    """`sections` counts from the bit up, whatever the number of elements in each."""
    own = [{"offset": 1e-3, "angle": 0.5}, {"offset": 0.0}, {"offset": 3e-3, "angle": -2.0}]
    lengths = ({"length": 1.0}, {"length": 3.0}, {"length": 1.0})
    scene = quiet_scene({"eccentricity": {"sections": own}}, sections=lengths, elements=25)
    twin = Twin(scene)
    places, found = twin.model.places, offsets(scene.effects.eccentricity, twin.model) @ [1.0, 1.0j]
    wanted = np.select([places < 1.0, places < 4.0], [1e-3 * np.exp(0.5j), 0.0], 3e-3 * np.exp(-2.0j))
    assert found == pytest.approx(wanted)


def test_random_mass_centres() -> None:
    """Mean zero, mean square rms^2, correlation exp(-(s / l)^2 / 2): over 400 seeds, within three standard errors."""
    model = Twin(quiet_scene({}, elements=20, length=20.0)).model
    blocks = [Eccentricity(rms=1e-3, correlation_length=0.7, seed=seed) for seed in range(400)]
    z = np.array([offsets(block, model) @ [1.0, 1.0j] for block in blocks]) / 1e-3
    error = 3.0 / np.sqrt(400 * 20.0 / 0.7 / 2.5)  # so many independent pieces of string
    assert abs(z.mean()) < error
    assert np.mean(np.abs(z) ** 2) == pytest.approx(1.0, abs=error)
    assert abs(np.mean(z**2)) < error, "no direction is preferred"
    apart = model.places[2] - model.places[0]
    assert np.mean(z[:, 2:] * z[:, :-2].conj()) == pytest.approx(np.exp(-((apart / 0.7) ** 2) / 2.0), abs=error)


def test_the_same_seed_is_the_same_string() -> None:
    """Whatever the mesh; another seed of the block or of the scene is another string."""
    block = Eccentricity(rms=1e-3, correlation_length=1.0, seed=5)
    coarse, fine = (Twin(quiet_scene({}, elements=n)).model for n in (10, 40))
    line = [np.interp(2.0, model.places, offsets(block, model)[:, 0]) for model in (coarse, fine)]
    assert line[0] == pytest.approx(line[1], abs=1e-4)
    others = [offsets(block.model_copy(update={"seed": 6}), fine), offsets(block, fine._replace(seed=2))]
    assert all(np.abs(other - offsets(block, fine)).max() > 1e-4 for other in others)
