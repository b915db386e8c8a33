# SPDX-License-Identifier: Apache-2.0
"""Topic contract: names, types and serialised messages, without ROS.

Nodes publish these bytes over DDS, and a run without ROS writes them to its bag, so that both bags are the same.
Definitions, type hashes and CDR come from rosbags' type store for Jazzy.
"""
