# SPDX-License-Identifier: Apache-2.0
"""drill_twin beside PyElastica, Exudyn and MuJoCo on one rod: `python -m drill_twin_evidence.benchmarks.peers --help`.

One small file per tool turns a `Task` (a scene and a resolution) into a `Motion` (the path of mid-span, and what it
cost). Each file says how its tool is set up; it is the best set-up we know, corrections included that the tool itself
neither makes nor documents.
"""
