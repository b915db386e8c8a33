# SPDX-License-Identifier: Apache-2.0
"""Orientation of a section, and transforms for tf2: the hole in the plumb frame `rig`, bit, marks and subs in the hole.

A section is turned by its spin about z, then by the shortest rotation of z onto the tangent.

`TransformsTemplate` encodes them as tf2_msgs/TFMessage without the message package, which only the publisher needs.
"""

from collections.abc import Sequence

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.dynamics.twin.frame import Frame
from drill_twin.io.messages.cdr import Template, sentinel_header, sentinels
from drill_twin.io.messages.drawing.geometry import ExaggeratedGeometry, StringGeometry
from drill_twin.io.messages.stamps import stamp_ns
from drill_twin.io.messages.topic_row import TF_TYPE
from drill_twin.io.messages.topics import FRAME_ID
from drill_twin.io.messages.type_store import message

_ANTIPARALLEL = 1e-12


def orientation(tangents: Array, spin: Array) -> Array:
    """Unit quaternions x y z w, shape (..., 4), of sections with these tangents and spins [rad].

    With a = (-t_y, t_x, 0, 1 + t_z)/sqrt(2 + 2 t_z), the shortest rotation of z onto t, the result is a times the
    rotation by the spin about z. A tangent straight down (t_z = -1) has no shortest rotation; the rotation about y is
    used.

    Args:
        tangents: Unit tangents, shape (..., 3).
        spin: Spins [rad], shape (...,).
    """
    half = 0.5 * spin
    cosine, sine = np.cos(half), np.sin(half)
    up = np.maximum(0.5 + 0.5 * tangents[..., 2], _ANTIPARALLEL)
    scalar = np.sqrt(up)
    x = -0.5 * tangents[..., 1] / scalar
    y = 0.5 * tangents[..., 0] / scalar
    down = up <= _ANTIPARALLEL
    if down.any():
        x[down], y[down], scalar[down] = 0.0, 1.0, 0.0
    return np.stack((x * cosine + y * sine, y * cosine - x * sine, scalar * sine, scalar * cosine), axis=-1)


def spin_of(quaternions: Array) -> Array:
    """Spins [rad], in (-2 pi, 2 pi], of quaternions x y z w, shape (..., 4): the inverse of `orientation`."""
    return 2.0 * np.arctan2(quaternions[..., 2], quaternions[..., 3])


def tangent_of(quaternions: Array) -> Array:
    """Unit tangents, shape (..., 3), of quaternions x y z w, shape (..., 4): the directions of their z axes."""
    x, y, z, w = np.moveaxis(quaternions, -1, 0)
    return np.stack((2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)), axis=-1)


RIG_FRAME = "rig"
"""Parent of `hole`, fixed to the rig: origin at the top clamp, z plumb up, hole inclined in the plane of x and z.

It is the root of the twin's tree. `map` and `earth` (REP 105) are the site's, which may give `rig` a place in them.
"""
BIT = "bit"


def static_message(inclination: float, prefix: str) -> bytes:
    """`/tf_static` of a twin: the hole in `rig`, its axis inclined [rad] so that +x of the hole is the low side."""
    half = 0.5 * inclination
    pose = np.array([[0.0, 0.0, 0.0, 0.0, np.sin(half), 0.0, np.cos(half)]])
    return TransformsTemplate(prefix + RIG_FRAME, [prefix + FRAME_ID]).fill(0, pose)


class StringTransforms:
    """Poses of the bit, of the marks and of the sensors of the subs of one string, in the hole."""

    def __init__(self, geometry: StringGeometry) -> None:
        from scipy.interpolate import CubicHermiteSpline  # 30 MB, which a node without transforms does not need

        self._spline = CubicHermiteSpline
        fixed = (BIT, *geometry.mark_names)
        subs = [sub for sub in geometry.subs if sub.name not in {FRAME_ID, RIG_FRAME, *fixed}]  # a frame has one parent
        names = [geometry.frame_prefix + name for name in (*fixed, *(sub.name for sub in subs))]
        self._subs = np.array([sub.distance_from_bit for sub in subs])
        self._radius, self._angle = np.array([sub.radius for sub in subs]), np.array([sub.angle for sub in subs])
        self._template = TransformsTemplate(geometry.frame_id, names)
        self._true = ExaggeratedGeometry(geometry, 1.0)
        self._nodes, self._marks = geometry.node_distances, np.array(geometry.mark_distances)

    def message(self, frame: Frame) -> bytes:
        """`/tf` of a frame of the twin."""
        along = np.concatenate(([0.0], self._marks, self._subs))
        tangents = np.stack([np.interp(along, self._nodes, column) for column in frame.tangents.T], axis=1)
        tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
        spin = np.concatenate(
            (frame.spin[:1], frame.marks.spin, np.interp(self._subs, self._nodes, frame.spin) + self._angle)
        )
        turns = orientation(tangents, spin)
        at = len(spin) - self._subs.size
        x, y, z, w = turns[at:].T
        outwards = np.stack((1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)), axis=1)
        sensors = self._spline(self._nodes, frame.positions, frame.tangents)(self._subs)
        sensors += self._radius[:, None] * outwards
        places = np.concatenate((frame.positions[:1], self._true.marks(frame.marks.position), sensors))
        return self._template.fill(stamp_ns(frame.time), np.concatenate((places, turns), axis=1))


class TransformsTemplate(Template):
    """tf2_msgs/TFMessage of frames in one parent."""

    def __init__(self, parent: str, children: Sequence[str]) -> None:
        """Lay out the message for these names."""
        blocks = sentinels(7 * len(children), 1).reshape(-1, 7)
        content = message(
            TF_TYPE,
            transforms=[
                message(
                    "geometry_msgs/msg/TransformStamped",
                    header=sentinel_header(parent),
                    child_frame_id=child,
                    transform=message(
                        "geometry_msgs/msg/Transform",
                        translation=message("geometry_msgs/msg/Vector3", x=row[0], y=row[1], z=row[2]),
                        rotation=message("geometry_msgs/msg/Quaternion", x=row[3], y=row[4], z=row[5], w=row[6]),
                    ),
                )
                for child, row in zip(children, blocks.tolist(), strict=True)
            ],
        )
        super().__init__(content, TF_TYPE, list(blocks))

    def fill(self, stamp: int, poses: Array) -> bytes:
        """CDR of the children's origins [m] and unit quaternions x y z w, shape (k, 7), at a stamp [ns]."""
        return self.rows([stamp], *poses[:, None])[0]
