# SPDX-License-Identifier: Apache-2.0
"""Tables, data and figure of torque, drag and buckling, in SI or field units."""
