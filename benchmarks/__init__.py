# SPDX-License-Identifier: Apache-2.0
"""Cost of the twin: beside other tools (`benchmarks.peers`), and of the kernel by itself (`benchmarks.kernel`)."""
