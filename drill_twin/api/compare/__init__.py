# SPDX-License-Identifier: Apache-2.0
"""Assemblies or set-points beside each other: what differs for a bit run."""
