# SPDX-License-Identifier: Apache-2.0
"""What the twin costs: beside other tools (`benchmarks.peers`), and of the kernel by itself (`benchmarks.kernel`)."""
