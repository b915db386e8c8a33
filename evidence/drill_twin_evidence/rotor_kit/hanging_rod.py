# SPDX-License-Identifier: Apache-2.0
"""The hanging rod: `python -m drill_twin_evidence.rotor_kit.hanging_rod FOLDER`, lateral frequencies of both rigs.

A plane beam on cubic elements with the tension of the weight below (Przemieniecki 1968, geometric stiffness), the
flywheel and the disc as rigid bodies, and a root with rotational stiffness.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.linalg import eigh
from scipy.optimize import brentq, least_squares

from drill_twin_evidence.rotor_kit.elements import Real
from drill_twin_evidence.rotor_kit.records import told

GRAVITY = 9.81  # [m/s2]
DIAMETER, YOUNG, DENSITY = 0.0127, 190e9, 7850.0  # [m, Pa, kg/m3] script of the source
STUB, ROD, TAIL = 0.07635, 1.697, 0.033  # [m] root to flywheel, flywheel to disc, disc to free end
FLYWHEEL_RADIUS, FLYWHEEL_WIDTH, CAST_IRON = 0.0889, 0.0127, 7200.0  # [m, m, kg/m3] density: handbook, grey iron
DISC_RADIUS, DISC_WIDTH, DISC_DENSITY = 0.0635, 0.00635, 8000.0
MEASURED = {"LD": (1.23, 9.7), "ROD": (1.6, 11.45)}  # [Hz] README of the data
ELEMENTS = (2, 14, 2)  # of stub, rod and tail: frequencies move by less than 1e-4 of themselves with twice as many


LOCKED = 5.0  # fold over the median within 0.3 Hz; chosen: no line at other speeds reaches 4 at half the rotation


@dataclass(frozen=True)
class Rod:
    """One of the two rigs: what the root and the ends are, in SI units."""

    with_disc: bool
    rotational: float  # [N m/rad] of the root
    lateral: float = np.inf  # [N/m] of the root
    gravity: float = GRAVITY
    tail: float = TAIL
    flywheel_density: float = CAST_IRON
    drop: float = 0.0  # [kg] added at the free end

    def bodies(self) -> list[tuple[int, float, float]]:
        """Return node, mass [kg] and diametral inertia [kg m2] of flywheel and disc."""
        found = []
        for node, radius, width, density in (
            (ELEMENTS[0], FLYWHEEL_RADIUS, FLYWHEEL_WIDTH, self.flywheel_density),
            (ELEMENTS[0] + ELEMENTS[1], DISC_RADIUS, DISC_WIDTH, DISC_DENSITY),
        ):
            mass = density * np.pi * (radius**2 - DIAMETER**2 / 4) * width
            found.append((node, mass, mass * (radius**2 / 4 + width**2 / 12)))
        return found if self.with_disc else found[:1]

    def matrices(self) -> tuple[Real, Real]:
        """Return mass and stiffness in one plane, coordinates a node: displacement [m] and slope [rad]."""
        sizes = np.repeat([STUB / ELEMENTS[0], ROD / ELEMENTS[1], self.tail / ELEMENTS[2]], ELEMENTS)
        area, second = np.pi * DIAMETER**2 / 4, np.pi * DIAMETER**4 / 64
        count = 2 * (len(sizes) + 1)
        mass, stiffness = np.zeros((count, count)), np.zeros((count, count))
        weights = np.zeros(len(sizes) + 1)
        for node, heavy, inertia in self.bodies():
            mass[2 * node, 2 * node] += heavy
            mass[2 * node + 1, 2 * node + 1] += inertia
            weights[node] += heavy * self.gravity
        mass[-2, -2] += self.drop
        weights[-1] += self.drop * self.gravity
        below = np.cumsum((sizes * area * DENSITY * self.gravity)[::-1])[::-1]
        for i, h in enumerate(sizes):
            tension = below[i] - h * area * DENSITY * self.gravity / 2 + weights[i + 1 :].sum()
            scale = np.array([1, h, 1, h])
            turn = np.outer(scale, scale)
            at = slice(2 * i, 2 * i + 4)
            bending = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
            slopes = np.array([[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) / 30
            moved = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420
            stiffness[at, at] += (YOUNG * second / h**3 * bending + tension / h * slopes) * turn
            mass[at, at] += DENSITY * (area * h * moved + second / h * slopes) * turn
        stiffness[1, 1] += self.rotational
        if np.isfinite(self.lateral):
            stiffness[0, 0] += self.lateral
            return mass, stiffness
        return mass[1:, 1:], stiffness[1:, 1:]

    def frequencies(self, count: int = 3) -> Real:
        """Return the lowest lateral frequencies at rest [Hz]."""
        mass, stiffness = self.matrices()
        squares = eigh(stiffness, mass, eigvals_only=True, subset_by_index=[0, count - 1])
        lowest: Real = np.sqrt(squares) / (2 * np.pi)
        return lowest


def root_of(frequency: float, mode: int, **changed: float | bool) -> float:
    """Return the rotational stiffness [N m/rad] with which a mode has a frequency [Hz]."""

    def off(logarithm: float) -> float:
        return float(Rod(rotational=float(np.exp(logarithm)), **changed).frequencies()[mode]) - frequency  # type: ignore[arg-type]

    return float(np.exp(brentq(off, np.log(1.0), np.log(1e7))))


@dataclass(frozen=True)
class Line:
    """The strongest free line of a spectrum near a mode."""

    nominal_rpm: int
    rotation: float  # [Hz] measured
    frequency: float  # [Hz]
    height: float  # [m/s] of both axes together
    above: float  # height over the median of the band


def spectra(folder: Path, run: str, rig: str) -> Iterator[tuple[int, float, Real, Real]]:
    """Yield nominal speed [rpm], measured rotation [Hz], frequencies [Hz] and height of both axes as power [m/s]."""
    first, second = (pd.read_csv(folder / f"{run}_{rig}_{axis}.csv") for axis in ("X", "Y"))
    turned = pd.read_csv(folder / "fresp.csv")
    speeds = turned[(turned.config == rig) & (turned.run == run)].rpm.unique()
    for nominal in sorted(first.rpm.unique()):
        one, two = first[first.rpm == nominal], second[second.rpm == nominal]
        frequency = one.frequency_hz.to_numpy()
        other = np.interp(frequency, two.frequency_hz, two.velocity_amplitude_m_s)
        height = np.hypot(one.velocity_amplitude_m_s.to_numpy(), other)
        yield int(nominal), float(speeds[np.abs(speeds - nominal).argmin()]) / 60, frequency, height


def free_lines(folder: Path, run: str, rig: str, band: tuple[float, float]) -> list[Line]:
    """Return the strongest line of each speed in a band [Hz] that is no multiple of the rotation.

    The two axes are added as power. Lines within 0.04 Hz of a multiple of the rotation are left out: the spectra
    have steps of 0.016 Hz, and a line is up to two steps wide on either side.
    """
    lines = []
    for nominal, rotation, frequency, height in spectra(folder, run, rig):
        multiple = np.abs(frequency / rotation - np.round(frequency / rotation)) * rotation
        free = (frequency > band[0]) & (frequency < band[1]) & (multiple > 0.04)
        if free.sum() < 5:
            continue
        top = np.flatnonzero(free)[height[free].argmax()]
        above = float(height[top] / np.median(height[free]))
        lines.append(Line(nominal, rotation, float(frequency[top]), float(height[top]), above))
    return lines


@dataclass(frozen=True)
class Locked:
    """The line of a spectrum at a part of the rotation."""

    nominal_rpm: int
    rotation: float  # [Hz] measured
    height: float  # [m/s] of both axes together
    above: float  # height over the median within 0.3 Hz
    over_rotation: float  # height over the line at the rotation


def locked_lines(folder: Path, run: str, rig: str, part: float) -> list[Locked]:
    """Return for each speed the line at a part of the rotation (0.5: one in two turns), within a step and a half."""
    found = []
    for nominal, rotation, frequency, height in spectra(folder, run, rig):

        def peak(centre: float, at: Real = frequency, size: Real = height) -> tuple[float, float]:
            near = np.abs(at - centre) < 0.025
            around = (np.abs(at - centre) > 0.05) & (np.abs(at - centre) < 0.3)
            top = float(size[near].max()) if near.any() else np.nan
            return top, top / float(np.median(size[around]))

        top, above = peak(part * rotation)
        found.append(Locked(nominal, rotation, top, above, top / peak(rotation)[0]))
    return found


def drift(lines: list[Line]) -> tuple[float, float]:
    """Return the slope of frequency over rotation [Hz/Hz] and its standard error."""
    x, y = np.array([one.rotation for one in lines]), np.array([one.frequency for one in lines])
    (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
    return float(slope), float(np.sqrt(covariance[0, 0]))


def gyroscopic_drift(rod: Rod, mode: int) -> float:
    """Return half the split between forward and backward of a mode a unit of rotation [Hz/Hz], to first order.

    Rayleigh's quotient of the polar inertias in the mode at rest (Genta 2005, section 2.7): the mode's frequency
    moves by plus and minus this times the rotation.
    """
    mass, stiffness = rod.matrices()
    _, modes = eigh(stiffness, mass)
    shift = 0 if np.isfinite(rod.lateral) else 1
    polar = sum(2 * inertia * modes[2 * node + 1 - shift, mode] ** 2 for node, _, inertia in rod.bodies())
    return float(polar) / 2


def main() -> int:
    """Print frequencies with one and with two fitted numbers, and the free lines of the spectra."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    print("one number (root, rotational) fitted on one frequency; LD 1, LD 2, ROD 1, ROD 2, error in percent:")
    for rig in MEASURED:
        for mode in (0, 1):
            root = root_of(MEASURED[rig][mode], mode, with_disc=rig == "LD")
            print(f"  {rig} {mode + 1}: {root:6.1f} N m/rad ", errors(root, np.inf).round(1))
    for name, modes in (("LD 2 and ROD 2", SECOND_MODES), ("all four", ALL_MODES)):
        root, lateral = root_fitted_on(modes)
        print(f"two numbers on {name}: {root:.1f} N m/rad, {lateral:.4g} N/m", errors(root, lateral).round(1))
    for run, rig in (("CCWUP", "LD"), ("CCWDOWN", "LD"), ("CCWUP", "ROD")):
        for band in ((1.0, 1.45), (9.3, 10.2)) if rig == "LD" else ((1.45, 1.9), (11.2, 12.5)):
            lines = free_lines(folder, run, rig, band)
            slope, error = drift(lines)
            print(f"{rig} {run} {band} Hz: drift {slope:+.3f} +- {error:.3f} Hz/Hz")
            for line in lines:
                ratio = line.frequency / line.rotation
                print(f"  {line.rotation:.3f} Hz: {line.frequency:.3f} Hz, {line.above:.1f} fold, ratio {ratio:.3f}")
        for part in (0.5, 1.5):
            for one in locked_lines(folder, run, rig, part):
                if one.above > LOCKED:
                    print(f"  at {part} of {one.rotation:.3f} Hz: {one.above:.0f} fold, {one.over_rotation:.2f} of 1x")
    return 0


def errors(rotational: float, lateral: float) -> Real:
    """Return the errors of LD 1, LD 2, ROD 1, ROD 2 [%]."""
    found = [Rod(rig == "LD", rotational, lateral).frequencies(2) / MEASURED[rig] - 1 for rig in MEASURED]
    return 100 * np.concatenate(found)


SECOND_MODES, ALL_MODES = (1, 3), (0, 1, 2, 3)  # of LD 1, LD 2, ROD 1, ROD 2


def root_fitted_on(modes: tuple[int, ...]) -> tuple[float, float]:
    """Return the rotational [N m/rad] and lateral stiffness [N/m] of the root with which these modes fit best."""

    def off(logarithms: Real) -> Real:
        return errors(*np.exp(logarithms))[list(modes)]

    found = least_squares(off, np.log([300.0, 3e4]), diff_step=1e-3)
    rotational, lateral = np.exp(found.x)
    return float(rotational), float(lateral)


if __name__ == "__main__":
    raise SystemExit(told(main))
