# SPDX-License-Identifier: Apache-2.0
"""MuJoCo 4.0: a one-dimensional flex, which is a discrete elastic rod, under the implicit "discrete" integrator.

Set-up. First order in time. The end vertices are held by joint springs of 1e8 N/m and the top edge is turned by its
twist joint (a pin would take that joint away, and MuJoCo has no clamp that slides). A rod clamped by two vertices
bends only from the second one's cell on and is one element too short; the clamps stand half an element inside, as for
PyElastica, and the weight beyond them is taken off. The rod does not stretch: edges are constraints, made as stiff as
the step allows, because the default ones let the hanging rod stretch by 16 cm. The wall is a ring of 24 planes whose
mean radius is the hole's, with MuJoCo's own contact, as stiff as the step allows too (the default sinks in by 4 mm),
and Coulomb friction of the coefficient that the turning rod has; the laws of Hertz and Stribeck cannot be told to it.
Drag is a damping of the vertices' joints.
"""

from __future__ import annotations

import mujoco
import numpy as np

from drill_twin_evidence.benchmarks.peers.rod import Rod, rod_of
from drill_twin_evidence.benchmarks.peers.task import Motion, Recorder, Task

PLANES = 24
HELD = 1e8
"""Stiffness that holds a vertex [N/m]; MuJoCo takes it implicitly."""
STIFFEST = 2.0
"""Time constant of contacts and edges over the step; MuJoCo takes no less."""
RESETS = (mujoco.mjtWarning.mjWARN_BADQACC, mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL)
TURNED = 1.0
"""Armature of the turned edge [kg m^2]; its rate is set before each step."""


def wall_xml(rod: Rod, soft: str) -> str:
    """Planes round the hole, facing inwards; their mean distance from the axis is the hole's radius."""
    if rod.law is None:
        return ""
    angles = 2.0 * np.pi * np.arange(PLANES) / PLANES
    half = np.pi / PLANES
    near = rod.hole * half / np.log(np.tan(half) + 1.0 / np.cos(half))
    speed = rod.rotation(rod.duration) * rod.radius
    mu = rod.law[3] / (1.0 + rod.law[4] * speed)
    return "".join(
        f'<geom type="plane" size="1 1 1" pos="{near * np.cos(a)} {near * np.sin(a)} {-rod.length / 2}" '
        f'zaxis="{-np.cos(a)} {-np.sin(a)} 0" condim="3" friction="{mu} 0 0" {soft}/>'
        for a in angles
    )


def model_of(task: Task, rod: Rod) -> mujoco.MjModel:
    """The compiled model."""
    n = task.elements
    cell, beyond = staggered(task, rod)
    points = " ".join(f"0 0 {beyond - i * cell}" for i in range(n + 1))
    elements = " ".join(f"{i} {i + 1}" for i in range(n))
    contact = 'contype="0" conaffinity="0"' if rod.law is None else 'contype="1" conaffinity="1"'
    mu = 0.0 if rod.law is None else rod.law[3] / (1.0 + rod.law[4] * rod.rotation(rod.duration) * rod.radius)
    soft = f'solref="{STIFFEST * task.step} 1"'
    text = f"""<mujoco>
  <option timestep="{task.step}" gravity="0 0 {-rod.gravity}" integrator="discrete"
    cone="elliptic"/>
  <size memory="64M"/>
  <worldbody>
    {wall_xml(rod, soft)}
    <flexcomp name="rod" dim="1" type="direct" point="{points}" element="{elements}" radius="{rod.radius}"
      mass="{rod.line_mass * cell * (n + 1)}">
      <contact selfcollide="none" condim="3" friction="{mu} 0 0" {soft} {contact}/>
      <edge equality="true" {edge_constraint(task)}/>
      <elasticity young="{rod.youngs_modulus}" shear="{rod.shear_modulus}" section="circle"/>
    </flexcomp>
  </worldbody>
</mujoco>"""
    return mujoco.MjModel.from_xml_string(text)


def staggered(task: Task, rod: Rod) -> tuple[float, float]:
    """Length of an edge, and how far the rod reaches beyond each clamp [m]."""
    return rod.staggered(task.elements, bool(task.options.get("plain")))


def edge_constraint(task: Task) -> str:
    """Time constant and impedance of the edges, as attributes."""
    return f'solref="{STIFFEST * task.step} 1" solimp="0.9999 0.9999 0.001"'


def run(task: Task) -> Motion:
    """Run a task; option `plain`: clamps as they come."""
    rod = rod_of(task)
    n = task.elements
    model = model_of(task, rod)
    data = mujoco.MjData(model)
    cell, beyond = staggered(task, rod)
    # vertex i has three slides, from the top down
    slides = np.array([[model.body(f"rod_{i}").dofadr[0] + k for k in range(3)] for i in range(n + 1)])
    model.dof_damping[slides[:, :2].ravel()] = rod.drag * cell
    turned = int(model.joint("rod_twist_0").dofadr[0])
    held = np.concatenate([slides[0], slides[1][:2], slides[-1][:2], slides[-2][:2]])
    model.jnt_stiffness[model.dof_jntid[held]] = HELD
    model.dof_armature[turned] = TURNED
    mujoco.mj_setConst(model, data)
    heights = rod.length + beyond - np.arange(n + 1) * cell
    data.qvel[slides[:, 0]] = rod.kick_at(heights.astype(np.float64))[0]
    push, weight = int(slides[-1, 2]), rod.line_mass * cell * rod.gravity
    period = rod.duration / rod.frames
    steps = round(period / task.step)
    recorder = Recorder(task.limit)
    for frame in range(1, rod.frames + 1):
        for _ in range(steps):
            data.qfrc_applied[push] = rod.weight_on_bit(data.time) + weight
            data.qvel[turned] = -rod.rotation(data.time)  # about the tangent, which points down
            mujoco.mj_step(model, data)
        recorder.steps += steps
        place = data.qpos[slides]
        reach = float(np.hypot(place[:, 0], place[:, 1]).max())
        if not recorder.take(frame * period, place[n // 2, :2], float(place[-1, 2]), reach):
            break
        if any(data.warning[kind].number for kind in RESETS):
            recorder.failure = f"reset itself at {frame * period:.3g} s after a number that was not finite"
            break
    return recorder.motion()
