# SPDX-License-Identifier: Apache-2.0
"""Large bending."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin_evidence.verify.case import case
from drill_twin_evidence.verify.row import Row
from drill_twin_evidence.verify.scenes import EI, LENGTH, rod_scene
from drill_twin_evidence.verify.signals import run_for

BENT = {
    "drag": {"linear": 0.4},
    "internal_damping": {"bending_time": 2e-3, "stretch_time": 2e-3, "torsion_time": 2e-3},
    "bit_stabiliser": {"gauge": 0.01, "stiffness": 1.0},
}
"""Damping that brings the rod to rest; the stabiliser has no contact."""


@case(degrees=(30.0, 70.0), direction=(0.0, 2.0))
def elastica(degrees: float, direction: float) -> Iterator[Row]:
    """Cantilever under a transverse dead load at the free bit, in two directions across the hole.

    Errors are relative to the length, or in radians; error of 24 elements: 1e-4.
    """
    tip = float(np.radians(degrees))
    force, aside, reach = cantilever(tip)
    place, tangent = _at_rest(24, force=force * EI / LENGTH**2, angle=direction)
    along = np.array([np.cos(direction), np.sin(direction), 0.0])
    formula, source = "EI theta'^2 / 2 = F (sin theta_0 - sin theta)", "Bisshopp and Drucker 1945"
    for what, exact, found in (
        ("deflection of the bit, of L [-]", aside, place @ along / LENGTH),
        ("distance of the bit from the axis, of L [-]", aside, np.hypot(place[0], place[1]) / LENGTH),
        ("reach of the bit along the axis, of L [-]", reach, -place[2] / LENGTH),
        ("tilt of the bit [rad]", tip, np.arctan2(-tangent @ along, tangent[2])),
    ):
        yield Row(what, formula, source, exact, float(found), 2e-4, relative=False)


@case(half_turns=(0.25, 0.5, 0.9))
def roll_up(half_turns: float) -> Iterator[Row]:
    """Cantilever under a moment at the free bit, which bends it to a circular arc.

    Errors are relative to the length, or in radians; error of 32 cubic elements: 2e-4. The reference frame of the twist
    is singular at a half turn.
    """
    angle = half_turns * np.pi
    place, tangent = _at_rest(32, moment=angle * EI / LENGTH, angle=0.7)
    along = np.array([np.cos(0.7), np.sin(0.7), 0.0])
    formula, source = "arc of radius EI / M", "Euler 1744"
    for what, exact, found, tolerance in (
        ("deflection of the bit, of L [-]", (1.0 - np.cos(angle)) / angle, place @ along / LENGTH, 2e-4),
        ("reach of the bit along the axis, of L [-]", np.sin(angle) / angle, -place[2] / LENGTH, 2e-4),
        ("tilt of the bit [rad]", angle, np.arctan2(-tangent @ along, tangent[2]), 1e-3),
    ):
        yield Row(what, formula, source, float(exact), float(found), tolerance, relative=False)


def _at_rest(elements: int, **side_force: float) -> tuple[Array, Array]:
    """Position of the bit [m] and its tangent at rest, below the clamp at the origin."""
    effects = BENT | {"bit_side_force": side_force | {"ramp": 3.0}}
    scene = rod_scene(effects=effects, bit_end="stabilised", elements=elements, step=0.02, frame_rate=10.0)
    u, v = run_for(scene, 30.0, interval=0.1).unknowns
    if np.abs(v[:, :3]).max() > 1e-4:
        raise ValueError(f"expected the rod to be at rest after 30 s, found it at {np.abs(v[:, :3]).max():.3g} m/s")
    return u[0, 0:3], u[0, 3:6] / np.linalg.norm(u[0, 3:6])


def cantilever(tip: float) -> tuple[float, float, float]:
    """F L^2 / EI, deflection / L and reach / L of a cantilever whose tip a transverse dead load rotates by an angle.

    Quadrature with theta = theta_0 (1 - w^2), which removes the singularity of the root.
    """
    node, weight = np.polynomial.legendre.leggauss(60)
    w, weight = 0.5 * (node + 1.0), 0.5 * weight
    theta = tip * (1.0 - w * w)
    ds = weight * 2.0 * tip * w / np.sqrt(2.0 * (np.sin(tip) - np.sin(theta)))
    root = ds.sum()
    return float(root**2), float((np.sin(theta) * ds).sum() / root), float((np.cos(theta) * ds).sum() / root)
