# SPDX-License-Identifier: Apache-2.0
"""Commands on the steady states of a scene, without simulation in time: statics, modes, steady whirl."""
