# SPDX-License-Identifier: Apache-2.0
"""Numbers of a scene from a record: ensembles, a likelihood, adaptive importance sampling."""

from drill_twin_studies.fitting.likelihood import of_features, of_series
from drill_twin_studies.fitting.posterior import Posterior
from drill_twin_studies.fitting.record import CHANNELS, SET_POINTS, Record, read_record
from drill_twin_studies.fitting.sampling import Sampling, sample

__all__ = [
    "CHANNELS",
    "SET_POINTS",
    "Posterior",
    "Record",
    "Sampling",
    "of_features",
    "of_series",
    "read_record",
    "sample",
]
