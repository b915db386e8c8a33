# SPDX-License-Identifier: Apache-2.0
"""Coverage on rigs that are not of the model: `python -m drill_twin_evidence.rotor_kit.synthetic [COUNT] [SEED]`.

A rig is drawn wider than the prior, its discs weigh differently, its bearings damp differently in x and y; the three
conditions are mounted with errors and measured; the fit and the forecast then run as on the record.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace

import numpy as np

from drill_twin_evidence.rotor_kit.elements import Complex, Rotors
from drill_twin_evidence.rotor_kit.fit import first_critical, run
from drill_twin_evidence.rotor_kit.forecast import MOUNT, SPEEDS, Forecast, complex_normal
from drill_twin_evidence.rotor_kit.posterior import Measured, scatter_of
from drill_twin_evidence.rotor_kit.records import COUNTED
from drill_twin_evidence.rotor_kit.rig import MICRO_PER_GRAM_MM, NAMES, RUNOUT_SPEED, Rigs

WIDER = 1.15  # of the prior's standard normal numbers: a truth that the prior takes for less likely than it is
UNEQUAL = 0.02  # of a disc's mass, standard deviation; the model has equal discs
TRUE_SCATTER = 0.25  # [um] between mounts
WEIGHT = 48.0  # [g mm] of A007 and A015
STEPS = 1200
LIKE = np.array([0.105, 0.209, 0.185])  # [um per g mm] p1y, p2x, p2y of the record, mean of both discs


@dataclass(frozen=True)
class Truth:
    """One synthetic rig."""

    rig: Rigs
    rotors: Rotors

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Truth:
        """Return a rig whose vectors a unit of unbalance are within 30 % of the record's."""
        while True:
            many = Rigs.of(WIDER * rng.standard_normal((400, len(NAMES))))
            many = Rigs(many.values[many.possible()])
            size = np.abs(many.sensitivities([SPEEDS[0]])[0]).mean(axis=2)
            alike = np.flatnonzero((np.abs(np.log(size[:, 1:] / LIKE)) < np.log(1.3)).all(axis=1))
            if len(alike):
                rig = Rigs(many.values[alike[:1]])
                break
        rotors = rig.rotors(4)
        share = 1 + UNEQUAL * rng.standard_normal((1, 2))
        discs = replace(
            rotors.discs,
            mass=rotors.discs.mass * share,
            polar=rotors.discs.polar * share,
            diametral=rotors.discs.diametral * share,
        )
        split = np.exp(0.5 * rng.standard_normal((1, 2, 1, 2))) * np.eye(2)
        bearings = replace(rotors.bearings, damping=rotors.bearings.damping @ split)
        return cls(rig, replace(rotors, discs=discs, bearings=bearings))

    def sensitivity(self, speed: float) -> Complex:
        """Return the vectors a unit of unbalance [um per g mm], shape (4, 2)."""
        places = self.rig.probe_places()
        shown = self.rig.seen(self.rotors.unbalance_response(speed, places))
        slow = self.rig.seen(self.rotors.unbalance_response(RUNOUT_SPEED, places)) * self.rig["runout_share"]
        turned: Complex = np.conj(shown - slow)[0] * np.exp(1j * np.deg2rad(self.rig["angle"][0])) * MICRO_PER_GRAM_MM
        return turned

    def measured(self, rng: np.random.Generator) -> Measured:
        """Return what BASE, A007 and A015 would have measured."""
        spread = scatter_of(np.array([TRUE_SCATTER]))[0]
        noise = spread[:, None] * complex_normal(rng, (4, 3))
        residual = 50.0 * complex_normal(rng, (2,))
        mounted = WEIGHT * (1 + MOUNT * complex_normal(rng, (2,)))
        clean = self.sensitivity(SPEEDS[0])
        base = clean @ residual + noise[:, 0]
        weighted = clean @ residual + (clean * mounted).T + noise[:, 1:].T
        return Measured(((weighted - base) / WEIGHT).T, np.array([WEIGHT, WEIGHT]), base)


def trial(seed: int) -> tuple[list[bool], list[float], list[float], bool, float]:
    """Return of one rig: vectors inside bands, errors of amplitude and phase [deg], critical inside, band's width."""
    rng = np.random.default_rng(seed)
    truth = Truth.drawn(rng)
    measured = truth.measured(rng)
    chains = run(measured, steps=STEPS, seed=seed, groups=2)
    z = chains.drawn(300, rng)
    forecast = Forecast.of(np.repeat(z, 4, axis=0), measured, rng)
    inside, amplitude, phase = [], [], []
    true = truth.sensitivity(SPEEDS[1])
    for disc in range(2):
        load = np.zeros((1, 2), complex)
        load[0, disc] = WEIGHT
        # The record's vector is itself mounted anew and measured.
        met = WEIGHT * true[:, disc] * (1 + MOUNT * complex_normal(rng, ()))
        met = met + scatter_of(np.array([TRUE_SCATTER]))[0] * complex_normal(rng, (4,))
        said = forecast.net(load, 1, rng)
        for probe in COUNTED:
            ratio = said[:, probe] / met[probe]
            for values, centre in ((np.abs(ratio), 1.0), (np.angle(ratio), 0.0)):
                low, high = np.quantile(values, [0.05, 0.95])
                inside.append(bool(low <= centre <= high))
            amplitude.append(float(np.median(np.abs(ratio)) - 1))
            phase.append(float(np.rad2deg(np.median(np.angle(ratio)))))
    critical = first_critical(Rigs.of(z[:, :-2]))
    low, middle, high = np.quantile(critical, [0.05, 0.5, 0.95])
    met_critical = first_critical(truth.rig)[0]
    return inside, amplitude, phase, bool(low <= met_critical <= high), float((high - low) / middle)


def main(arguments: list[str]) -> int:
    """Print the coverage over synthetic rigs."""
    count, seed = int(arguments[0]) if arguments else 40, int(arguments[1]) if len(arguments) > 1 else 100
    found = [trial(seed + i) for i in range(count)]
    held = [one for trial_found in found for one in trial_found[0]]
    amplitude = np.array([one for trial_found in found for one in trial_found[1]])
    phase = np.array([one for trial_found in found for one in trial_found[2]])
    print(f"{count} rigs: vectors at 1,206 rpm inside 90 % bands {100 * np.mean(held):.1f} %")
    print(f"rms errors there {100 * np.sqrt(np.mean(amplitude**2)):.1f} %, {np.sqrt(np.mean(phase**2)):.2f} deg")
    print(f"first critical speed inside its band {100 * np.mean([one[3] for one in found]):.1f} %")
    print(f"width of that band, median {100 * np.median([one[4] for one in found]):.1f} %")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
