# SPDX-License-Identifier: Apache-2.0
"""Summary of a recording, of an open bag, or of the bag at a path."""

from pathlib import Path
from typing import Any

from drill_twin.io.bag.reader import Bag
from drill_twin.report.recording import Recording, read_recording
from drill_twin.report.summary import summarise as summary_of


def summarise(bag: Recording | Bag | str | Path) -> dict[str, Any]:
    """As `drill_twin.report.summary.summarise`."""
    if isinstance(bag, Bag):
        bag = Recording(bag)
    return summary_of(bag if isinstance(bag, Recording) else read_recording(bag))
