# SPDX-License-Identifier: Apache-2.0
"""The topic contract as code: names, types and the bytes on the wire, without ROS itself.

Nodes publish these bytes over DDS and `session` writes them to a bag, so a bag is the same whoever wrote it.
Definitions, type hashes and CDR come from rosbags' type store for Jazzy.
"""
