# SPDX-License-Identifier: Apache-2.0
"""Unknowns of the rotor kit, their priors with the ground of each, and the rotor that a draw of them describes.

Every unknown is a function of one standard normal number, so the prior of a whole rig is N(0, I) and the sampler
needs no bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from drill_twin_evidence.rotor_kit.elements import STEEL_DENSITY, Bearings, Complex, Discs, Real, Rotors, mesh

Flags = NDArray[np.bool_]

DIAMETER = 0.010  # [m] of the shaft, stated
YOUNG = 205e9  # [Pa] steel, handbook 200 to 210
DISC_DIAMETER, DISC_THICKNESS = 0.076, 0.025  # [m] stated
PARTS = 1  # elements between bearing, disc, disc and bearing: vectors of the prior move by 0.12 % at most with 8
LIKELY = 0.75  # of 480 mm between bearings: 560 mm is also stated as the whole shaft; chosen, not measured
RUNOUT_SPEED = 251 * 2 * np.pi / 60  # [rad/s] of the record that was subtracted as run-out
MICRO_PER_GRAM_MM = 1e6 * 1e-6  # response in m per kg m times this is um per g mm


@dataclass(frozen=True)
class Prior:
    """One unknown: its name, its law, and what the law rests on."""

    name: str
    law: str  # "normal", "log-normal", "uniform" or "log-uniform"
    low: float  # mean or median, or lower end
    high: float  # standard deviation (of the logarithm for log-normal), or upper end
    ground: str

    def value(self, z: Real) -> Real:
        """Return the unknown at standard normal numbers."""
        if self.law == "normal":
            straight: Real = self.low + self.high * z
            return straight
        if self.law == "log-normal":
            result: Real = self.low * np.exp(self.high * z)
            return result
        share = ndtr(z)
        if self.law == "uniform":
            spread: Real = self.low + (self.high - self.low) * share
            return spread
        even: Real = self.low * (self.high / self.low) ** share
        return even


def _bearing(number: int) -> tuple[Prior, ...]:
    return (
        Prior(f"stiffness_{number}", "log-normal", 1e6, 1.6, "[N/m] the source's 'typical', within a factor of 14"),
        Prior(f"anisotropy_{number}", "log-normal", 1.0, 0.5, "ratio of the two principal stiffnesses, not known"),
        Prior(f"axis_{number}", "uniform", -90.0, 90.0, "[deg] of the principal axes from probe x, not known"),
        Prior(f"cross_{number}", "normal", 0.0, 0.03, "skew over direct stiffness: a dry or lightly oiled bush"),
        Prior(f"damping_{number}", "log-normal", 50.0, 1.6, "[N s/m] the source's 'typical', within a factor of 14"),
        Prior(f"rotational_{number}", "log-uniform", 0.1, 300.0, "[N m/rad] a free bush to one of 30 mm on 4e6 N/m"),
    )


PRIORS = (
    Prior("frame", "uniform", 0.0, 1.0, "below 0.75: bearings at 40 and 520 mm of a 560 mm shaft; else at 0 and 560"),
    Prior("span_error", "normal", 0.0, 12.0, "[mm] of the distance between bearings: a bush has 20 to 30 mm"),
    Prior("disc_place_1", "normal", 160.0, 18.0, "[mm] on the shaft; 'typical' by the source, moved by a hub or less"),
    Prior("disc_place_2", "normal", 400.0, 18.0, "[mm] on the shaft; 'typical' by the source, moved by a hub or less"),
    Prior("probe_place_1", "normal", 120.0, 25.0, "[mm] on the shaft; 'typical' by the source, a stand on a slide"),
    Prior("probe_place_2", "normal", 440.0, 25.0, "[mm] on the shaft; 'typical' by the source, a stand on a slide"),
    Prior("disc_mass", "uniform", 0.79, 0.88, "[kg] 0.80 assumed by the source, 0.87 if solid steel"),
    Prior("shaft_stiffness", "log-normal", 1.04, 0.04, "of E I with 205 GPa; hubs of 25 mm stiffen 5 to 10 % of it"),
    *_bearing(1),
    *_bearing(2),
    Prior(
        "disc_damping", "log-uniform", 0.003, 0.06, "damping ratio at 35 Hz beside the bearings: 8 to 170 fold peaks"
    ),
    Prior("angle", "uniform", -180.0, 180.0, "[deg] of hole 0 from the keyphasor and of probe x: nowhere stated"),
    Prior("probe_angle_p1y", "normal", 90.0, 5.0, "[deg] from p2x; two probes at right angles, by hand"),
    Prior("probe_angle_p2y", "normal", 90.0, 5.0, "[deg] from p2x; two probes at right angles, by hand"),
    Prior("probe_angle_p1x", "normal", 0.0, 30.0, "[deg] from p2x; the poor channel of the source"),
    Prior("gain", "log-normal", 1.0, 0.03, "of all probes: API 670 allows 5 % at the edges of its range"),
    Prior("gain_p1y", "log-normal", 1.0, 0.03, "of one probe against the mean"),
    Prior("gain_p2x", "log-normal", 1.0, 0.03, "of one probe against the mean"),
    Prior("gain_p2y", "log-normal", 1.0, 0.03, "of one probe against the mean"),
    Prior("gain_p1x", "log-normal", 1.0, 0.3, "the poor channel of the source"),
    Prior("runout_share", "uniform", 0.0, 1.0, "of the weights' own motion at 251 rpm in the run-out: not stated"),
)
NAMES = tuple(prior.name for prior in PRIORS)


@dataclass(frozen=True)
class Rigs:
    """Draws of the rotor kit: values of shape (n, unknowns) in the order of NAMES."""

    values: Real

    @classmethod
    def of(cls, z: Real) -> Rigs:
        """Return the rigs at standard normal numbers of shape (n, unknowns)."""
        return cls(np.stack([prior.value(z[:, i]) for i, prior in enumerate(PRIORS)], axis=1))

    def __getitem__(self, name: str) -> Real:
        """Return the values of one unknown, shape (n,)."""
        return self.values[:, NAMES.index(name)]

    def _both(self, name: str) -> Real:
        return np.stack([self[f"{name}_1"], self[f"{name}_2"]], axis=1)

    @property
    def _first_bearing(self) -> Real:
        """Place of bearing 1 on the shaft of 560 mm [m], shape (n,)."""
        return np.where(self["frame"] < LIKELY, 0.040, 0.0) - 0.0005 * self["span_error"]

    @property
    def span(self) -> Real:
        """Distance between the bearings [m], shape (n,)."""
        return 0.560 - 2 * self._first_bearing

    def disc_places(self) -> Real:
        """Return the places of the discs from bearing 1 [m], shape (n, 2)."""
        return 1e-3 * self._both("disc_place") - self._first_bearing[:, None]

    def probe_places(self) -> Real:
        """Return the places of the two pairs of probes from bearing 1 [m], shape (n, 2)."""
        return 1e-3 * self._both("probe_place") - self._first_bearing[:, None]

    def possible(self) -> Flags:
        """Return where the parts have room: probes and discs on the span, no probe inside a disc."""
        span, discs, probes = self.span[:, None], self.disc_places(), self.probe_places()
        clear = np.abs(discs - probes) > DISC_THICKNESS / 2 + 0.006  # 8 mm tip of a probe and 2 mm of air
        inside = (discs > 0.02) & (discs < span - 0.02) & (probes > 0.01) & (probes < span - 0.01)
        order = (probes[:, 0] < discs[:, 0]) & (discs[:, 0] < discs[:, 1]) & (discs[:, 1] < probes[:, 1])
        result: Flags = (clear & inside).all(axis=1) & order
        return result

    def rotors(self, parts: int = PARTS) -> Rotors:
        """Return the finite elements of the rigs; shaft beyond the bearings (40 mm, 25 g) is left out."""
        span = self.span
        area = np.pi * DIAMETER**2 / 4
        second = np.pi * DIAMETER**4 / 64
        mass = np.repeat(self["disc_mass"][:, None], 2, axis=1)
        radius2 = (DISC_DIAMETER / 2) ** 2
        discs = Discs(
            self.disc_places(),
            mass,
            mass * (radius2 / 4 + DISC_THICKNESS**2 / 12),
            mass * radius2 / 2,
            mass * 2 * (2 * np.pi * 35.0) * self["disc_damping"][:, None],
        )
        places = np.stack([np.zeros_like(span), span], axis=1)
        breaks = np.concatenate([places[:, :1], discs.places, places[:, 1:]], axis=1)
        mean, ratio = self._both("stiffness"), self._both("anisotropy")
        turn = np.deg2rad(self._both("axis"))
        c, s = np.cos(turn), np.sin(turn)
        first, second_axis = mean * np.sqrt(ratio), mean / np.sqrt(ratio)
        skew = self._both("cross") * mean
        off = (first - second_axis) * c * s
        stiffness = np.stack(
            [first * c**2 + second_axis * s**2, off + skew, off - skew, first * s**2 + second_axis * c**2], axis=-1
        ).reshape(len(span), 2, 2, 2)
        damping = self._both("damping")[..., None, None] * np.eye(2)
        return Rotors(
            mesh(breaks, parts),
            YOUNG * second * self["shaft_stiffness"],
            np.full_like(span, STEEL_DENSITY * area),
            DIAMETER,
            discs,
            Bearings(places, stiffness, damping, self._both("rotational")),
        )

    def seen(self, motion: Complex) -> Complex:
        """Return what p1x, p1y, p2x, p2y show of motion at the two pairs, (n, 2 places, 2 axes, ...): (n, 4, ...)."""
        angles = (self["probe_angle_p1x"], self["probe_angle_p1y"], np.zeros(len(self.values)), self["probe_angle_p2y"])
        gains = [self["gain"] * self[f"gain_{probe}"] for probe in ("p1x", "p1y", "p2x", "p2y")]
        shown = []
        for probe, (angle, gain) in enumerate(zip(angles, gains, strict=True)):
            pair, turn = motion[:, probe // 2], np.deg2rad(angle)
            tail = (slice(None), *[None] * (pair.ndim - 2))
            shown.append(gain[tail] * (pair[:, 0] * np.cos(turn)[tail] + pair[:, 1] * np.sin(turn)[tail]))
        return np.stack(shown, axis=1)

    def sensitivities(self, speeds: list[float]) -> Complex:
        """Return vectors a unit of unbalance [um per g mm, lag] at speeds [rad/s]: (speeds, n, 4 probes, 2 discs).

        Part of the response at 251 rpm is subtracted: the share that the run-out record held of it.
        """
        rotors, places = self.rotors(), self.probe_places()
        slow = self.seen(rotors.unbalance_response(RUNOUT_SPEED, places)) * self["runout_share"][:, None, None]
        common = np.exp(1j * np.deg2rad(self["angle"]))[:, None, None] * MICRO_PER_GRAM_MM
        shown = [self.seen(rotors.unbalance_response(speed, places)) - slow for speed in speeds]
        return np.stack([np.conj(one) * common for one in shown])
