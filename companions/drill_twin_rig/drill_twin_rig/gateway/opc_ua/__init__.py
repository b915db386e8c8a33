# SPDX-License-Identifier: Apache-2.0
"""OPC UA: server of the signals of the twin, client of a rig's server, and the keys of both."""
