# SPDX-License-Identifier: Apache-2.0
"""What a step of the twin costs, by effect and against the machine's limit: `python -m benchmarks.kernel --help`."""
