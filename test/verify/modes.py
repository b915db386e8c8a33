# SPDX-License-Identifier: Apache-2.0
"""The signal tools of the exact checks, for the tests beside them."""

from drill_twin.studies.verify.signals import free_motion, squared_frequencies

__all__ = ["free_motion", "squared_frequencies"]
