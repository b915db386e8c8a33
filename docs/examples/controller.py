# SPDX-License-Identifier: Apache-2.0
"""A controller in the loop: it raises the weight on bit until the string whirls, then backs off.

Usage: controller.py [SECONDS]
"""

import sys

import drill_twin as dt


def main(seconds: float = 30.0) -> None:
    """Drill for so long [s]."""
    simulation = dt.Simulation("pa6_bench")
    state = simulation.advance(wob=0.0, rpm=120.0)
    while state.time < seconds:
        weight = state.weight_on_bit + 2.0 if state.onset_s is None else 0.5 * state.weight_on_bit
        state = simulation.advance(wob=weight, rpm="120 rpm", seconds=0.5)
        print(f"{state.time:5.2f} s: {state.weight_on_bit:5.1f} N, bit {state.bit_rpm:5.1f} rpm, {state.motion}")
    print(simulation.result())


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 30.0)
