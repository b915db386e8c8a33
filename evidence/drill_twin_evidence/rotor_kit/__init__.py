# SPDX-License-Identifier: Apache-2.0
"""The measured rotor kit and the hanging rod: own finite elements, fit, and predictions made before the answer."""
