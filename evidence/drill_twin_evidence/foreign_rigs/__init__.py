# SPDX-License-Identifier: Apache-2.0
"""Records of torsional rigs that are not of our model, and what fit and estimator make of them."""
