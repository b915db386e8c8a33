# SPDX-License-Identifier: Apache-2.0
"""Labels of the cost figure are apart from each other and inside the panel."""

from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from drill_twin.studies.accuracy import figures


def test_labels_do_not_overlap():
    runs = [
        SimpleNamespace(
            cost=seconds,
            resolution=SimpleNamespace(form="spatial", elements=8 * k, step=5e-3 / k, tolerance=None),
            errors=SimpleNamespace(path=1e-2 / k**2),
        )
        for k, seconds in enumerate(np.geomspace(4e-3, 0.2, 9), start=1)
    ]
    curve: Any = SimpleNamespace(runs=runs, noise=SimpleNamespace(path=None))
    figure = Figure(figsize=(11.0, 5.0), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    panel = figure.subplots(1, 2)[0]
    figures._panel(panel, curve, "path", "path")
    canvas.draw()
    boxes = [text.get_window_extent() for text in panel.texts]
    assert len(boxes) >= 4
    assert not any(one.overlaps(other) for k, one in enumerate(boxes) for other in boxes[:k])
    assert all(box.x0 >= panel.bbox.x0 and box.x1 <= panel.bbox.x1 for box in boxes)
