# SPDX-License-Identifier: Apache-2.0
"""Rig software and the twin: a gateway by OPC UA and WITS 0, and files of the Drillbotics competition."""
