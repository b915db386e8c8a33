# SPDX-License-Identifier: Apache-2.0
"""From a well plan (survey, casing, pipe tally, mud, bit) to a scene."""
