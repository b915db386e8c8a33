# SPDX-License-Identifier: Apache-2.0
"""Scene of the simulated cases: a bench like the paper's, fixed here so that the scores stay comparable."""

BENCH_SCENE = """\
name: detection_bench
description: A polyamide rod of 5 m in a hole of 90 mm radius, pushed with 40 N and turned at 2 rev/s.
provenance: >-
  Rod, hole radius, weight on bit and speed as in doi 10.3389/feart.2024.1396784; the rest is chosen.
string:
  sections:
    - name: rod
      length: 5000 mm
      outer_diameter: 16.5 mm
      youngs_modulus: 2.3 GPa
      poisson_ratio: 0.394
      density: 1.10 g/cm^3
  marks:
    - {name: mark_1, distance_from_bit: 4400 mm}
    - {name: mark_2, distance_from_bit: 2500 mm}
    - {name: mark_3, distance_from_bit: 500 mm}
  bit_end: sliding
hole:
  radius: 90 mm
rig:
  weight_on_bit: {shape: step, value: 40 N, duration: 15 s, at: bit}
  rotation: {shape: ramp, value: 2 rev/s, duration: 0.5 s}
  duration: 30 s
effects:
  gravity: {}
  stretch: {}
  torsion: {}
  bow: {amplitude: 2 mm}
  eccentricity: {offset: 0.1 mm}
  internal_damping: {bending_time: 4 ms, stretch_time: 1 ms, torsion_time: 1 ms}
  drag: {linear: 0.2 N s/m^2}
  wall: {stiffness: 1e7 N/m^2.5, restitution: 0.5}
  wall_friction: {coefficient: 0.01}
numerics:
  frame_rate: 100 Hz
"""
