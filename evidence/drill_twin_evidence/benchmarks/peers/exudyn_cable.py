# SPDX-License-Identifier: Apache-2.0
"""Exudyn 1.13: ANCF cable elements (cubic, no torsion), implicit trapezoidal rule or generalized alpha.

Set-up. The compiled module without range checks (EXUDYN_MODULE=fast); sparse factorisation; modified Newton; steps cut
by Exudyn where Newton fails. Drag and wall come in as one `ObjectGenericODE2` over all nodes whose forces and Jacobian
are compiled by numba: one call per evaluation in place of a Python connector per node, which costs several times as
much and leaves the wall out of Newton's tangent. The element has no torsion: the spin in the friction is that of the
top. Smooth motion runs on the trapezoidal rule (second order, no damping), contact on generalized alpha with a spectral
radius of 0.8.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items  # noqa: N813  the name of a module, whatever its spelling
from numba import njit

from drill_twin_evidence.benchmarks.peers.rod import Rod, rod_of, wall_force
from drill_twin_evidence.benchmarks.peers.task import Array, Motion, Recorder, Task

COORDINATES = 6  # of a node: place and slope


@njit(cache=True, error_model="numpy")
def forces(law: Array, wall: bool, drag: float, share: Array, spin: float, q: Array, v: Array, force: Array) -> None:
    """Drag and wall on each node; `share` is the length that it stands for [m]."""
    for i in range(share.size):
        a = COORDINATES * i
        force[a : a + 3] = -drag * share[i] * v[a : a + 3]
        if wall:
            fx, fy, fz, _ = wall_force(law, q[a], q[a + 1], v[a], v[a + 1], v[a + 2], spin)
            force[a] += share[i] * fx
            force[a + 1] += share[i] * fy
            force[a + 2] += share[i] * fz


@njit(cache=True, error_model="numpy")
def tangent(
    law: Array, wall: bool, drag: float, share: Array, spin: float, q: Array, v: Array, by_place: float,
    by_speed: float, values: Array,
) -> None:  # fmt: skip
    """Minus the derivative of `forces`, a 3 x 3 block per node, by central differences of the law."""
    at = np.empty(6)
    near, slow = 1e-7, 1e-6
    for i in range(share.size):
        a = COORDINATES * i
        for j in range(3):
            for k in range(3):
                values[i, j, k] = by_speed * drag * share[i] if j == k else 0.0
        if not wall or q[a] * q[a] + q[a + 1] * q[a + 1] < (law[0] - near) ** 2:
            continue
        for k in range(6):
            if k == 2:
                continue  # along the hole nothing changes
            small = near if k < 3 else slow
            factor = by_place if k < 3 else by_speed
            at[:3], at[3:] = q[a : a + 3], v[a : a + 3]
            at[k] += small
            one = wall_force(law, at[0], at[1], at[3], at[4], at[5], spin)
            at[k] -= 2.0 * small
            two = wall_force(law, at[0], at[1], at[3], at[4], at[5], spin)
            for j in range(3):
                values[i, j, k % 3] -= factor * share[i] * (one[j] - two[j]) / (2.0 * small)


def add_cable(mbs: Any, rod: Rod, n: int) -> list[int]:
    """Nodes from the bottom up and the elements between them, hanging at rest; returns the nodes."""
    heights = np.linspace(0.0, rod.length, n + 1)
    kick, slope = rod.kick_at(heights)
    fall, strain = rod.hung(heights)
    nodes = [
        mbs.AddNode(items.NodePointSlope1(
            referenceCoordinates=[0.0, 0.0, height - rod.length, 0.0, 0.0, 1.0],
            initialCoordinates=[0.0, 0.0, fall[i], 0.0, 0.0, strain[i]],
            initialVelocities=[kick[i], 0.0, 0.0, slope[i], 0.0, 0.0],
        ))
        for i, height in enumerate(heights)
    ]  # fmt: skip
    for lower, upper in pairwise(nodes):
        cable = mbs.AddObject(items.ObjectANCFCable(
            length=rod.length / n, massPerLength=rod.line_mass, nodeNumbers=[lower, upper],
            bendingStiffness=rod.youngs_modulus * rod.second_moment, axialStiffness=rod.youngs_modulus * rod.area,
        ))  # fmt: skip
        if rod.gravity:
            mass = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=cable))
            mbs.AddLoad(items.LoadMassProportional(markerNumber=mass, loadVector=[0.0, 0.0, -rod.gravity]))
    return nodes


def hold_ends(mbs: Any, nodes: list[int]) -> None:
    """The top clamped, the bottom free to slide along the axis; stretch is free at both."""
    ground = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0))
    for node, held in ((nodes[-1], (0, 1, 2, 3, 4)), (nodes[0], (0, 1, 3, 4))):
        for coordinate in held:
            marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
            mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, marker]))


def add_forces(mbs: Any, rod: Rod, nodes: list[int]) -> None:
    """Drag and wall on all nodes in one object."""
    n = len(nodes) - 1
    share = np.full(n + 1, rod.length / n)
    share[[0, -1]] *= 0.5
    law, wall = (np.zeros(8), False) if rod.law is None else (rod.law, True)
    size = COORDINATES * (n + 1)
    force, values = np.zeros(size), np.zeros((n + 1, 3, 3))
    first = COORDINATES * np.arange(n + 1)[:, None, None] + np.arange(3)[None, :, None]
    second = COORDINATES * np.arange(n + 1)[:, None, None] + np.arange(3)[None, None, :]
    triplets = np.empty((values.size, 3))
    triplets[:, 0] = np.broadcast_to(first, values.shape).ravel()
    triplets[:, 1] = np.broadcast_to(second, values.shape).ravel()

    def push(_mbs: Any, time: float, _item: int, q: Array, v: Array) -> Array:
        forces(law, wall, rod.drag, share, rod.rotation(time), np.asarray(q), np.asarray(v), force)
        return force

    def jacobian(_mbs: Any, time: float, _item: int, q: Array, v: Array, by_place: float, by_speed: float) -> Any:
        tangent(
            law, wall, rod.drag, share, rod.rotation(time), np.asarray(q), np.asarray(v), by_place, by_speed, values
        )
        triplets[:, 2] = values.ravel()
        matrix = exu.MatrixContainer()
        matrix.SetWithSparseMatrix(triplets[triplets[:, 2] != 0.0], size, size)
        return matrix

    nothing = exu.MatrixContainer()
    nothing.SetWithSparseMatrix(np.array([[0.0, 0.0, 0.0]]), size, size)
    mbs.AddObject(items.ObjectGenericODE2(
        nodeNumbers=nodes, massMatrix=nothing, forceUserFunction=push, jacobianUserFunction=jacobian
    ))  # fmt: skip


def settings_of(task: Task, rod: Rod, recorder: Recorder, mbs: Any) -> Any:
    """Settings of the solver: nothing written, modified Newton, sparse factors."""
    period = rod.duration / rod.frames
    settings = exu.SimulationSettings()
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = period
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.endTime = rod.duration
    settings.timeIntegration.numberOfSteps = round(rod.duration / task.step)
    settings.timeIntegration.newton.useModifiedNewton = True
    # its own 1e-8 lies below the round-off of stiff elements with short steps, which would then be cut and fail; looser
    # than this, errors grow before times fall
    rough = rod.law is not None or task.step > 1e-3
    settings.timeIntegration.newton.relativeTolerance = 1e-4 if rough else 1e-5
    settings.timeIntegration.newton.absoluteTolerance = 1e-7 if rod.law is None else 1e-6
    settings.timeIntegration.generalizedAlpha.spectralRadius = task.options.get("radius", 0.8)
    settings.linearSolverType = exu.LinearSolverType.EigenSparse

    def watch(_mbs: Any, time: float) -> bool:
        recorder.steps += 1
        return recorder.in_time(time)

    mbs.SetPreStepUserFunction(watch)
    return settings


def run(task: Task) -> Motion:
    """Run a task; option `radius`: spectral radius of generalized alpha, 1 = trapezoidal rule."""
    rod = rod_of(task)
    n = task.elements
    system = exu.SystemContainer()
    mbs = system.AddSystem()
    nodes = add_cable(mbs, rod, n)
    fall = float(rod.hung(np.zeros(1))[0][0])
    hold_ends(mbs, nodes)
    if rod.law is not None or rod.drag:
        add_forces(mbs, rod, nodes)
    bit = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[0]))
    mbs.AddLoad(items.LoadForceVector(
        markerNumber=bit, loadVectorUserFunction=lambda _mbs, time, _load: [0.0, 0.0, rod.weight_on_bit(time)]
    ))  # fmt: skip
    seen = [
        mbs.AddSensor(items.SensorNode(
            nodeNumber=node, storeInternal=True, writeToFile=False,
            outputVariableType=exu.OutputVariableType.Displacement,
        ))
        for node in nodes
    ]  # fmt: skip
    mbs.Assemble()
    recorder = Recorder(task.limit)
    settings = settings_of(task, rod, recorder, mbs)
    smooth = rod.law is None
    solver = exu.DynamicSolverType.TrapezoidalIndex2 if smooth else exu.DynamicSolverType.GeneralizedAlpha
    try:
        mbs.SolveDynamic(settings, solverType=solver)
    except (ValueError, RuntimeError) as error:
        recorder.failure = recorder.failure or f"{type(error).__name__}: {str(error).strip().splitlines()[0]}"
    motion = recorder.motion()
    stored = np.array([mbs.GetSensorStoredData(sensor) for sensor in seen])[:, 1:]
    reach = np.hypot(stored[:, :, 1], stored[:, :, 2]).max(axis=0)
    return Motion(
        stored[0, :, 0], stored[n // 2, :, 1:3], stored[0, :, 3] - fall, reach, motion.cpu, recorder.steps,
        recorder.failure,
    )  # fmt: skip
