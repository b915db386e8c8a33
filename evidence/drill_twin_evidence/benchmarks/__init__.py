# SPDX-License-Identifier: Apache-2.0
"""Cost of the twin: beside other tools (`peers`), and of the kernel by itself (`kernel`)."""
