# SPDX-License-Identifier: Apache-2.0
"""Calibration of the parameters that the paper does not give."""
