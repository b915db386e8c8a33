# SPDX-License-Identifier: Apache-2.0
"""Cost of a step of the twin, by effect and against the machine's limit.

python -m drill_twin_evidence.benchmarks.kernel --help
"""
