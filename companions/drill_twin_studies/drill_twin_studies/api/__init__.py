# SPDX-License-Identifier: Apache-2.0
"""Functions of the Python API."""
