# SPDX-License-Identifier: Apache-2.0
"""Run the notebooks of this folder and write what their cells print and draw: `python docs/notebooks/run.py`.

Without Jupyter: a cell is Python code, whose last expression is shown; a figure becomes a small picture.
"""

from __future__ import annotations

import ast
import base64
import json
from contextlib import redirect_stdout
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

from PIL import Image

FOLDER = Path(__file__).parent
WIDTH, COLOURS = 760, 48
"""Width [pixels] and colours of a picture."""


def executed(notebook: dict[str, Any]) -> dict[str, Any]:
    """Notebook with the outputs of its cells, run in order in one namespace.

    Args:
        notebook: Content of an .ipynb (nbformat 4).
    """
    names: dict[str, Any] = {"__name__": "__main__"}
    count = 0
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        count += 1
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        said = StringIO()
        with redirect_stdout(said):
            exec(compile(tree, f"cell {count}", "exec"), names)  # noqa: S102
            shown = None if last is None else eval(compile(ast.Expression(last.value), f"cell {count}", "eval"), names)  # noqa: S307
        cell["execution_count"], cell["outputs"] = count, []
        if text := said.getvalue():
            cell["outputs"].append({"name": "stdout", "output_type": "stream", "text": text.splitlines(keepends=True)})
        if shown is not None:
            cell["outputs"].append(
                {"output_type": "execute_result", "execution_count": count, "metadata": {}, "data": _data(shown)}
            )
    return notebook


def _data(shown: Any) -> dict[str, Any]:
    if hasattr(shown, "_repr_png_"):
        image = Image.open(BytesIO(shown._repr_png_())).convert("RGB")
        image = image.resize((WIDTH, round(WIDTH * image.height / image.width)), Image.Resampling.LANCZOS)
        drawn = BytesIO()
        image.quantize(COLOURS).save(drawn, "png", optimize=True)
        return {"image/png": base64.b64encode(drawn.getvalue()).decode()}
    return {"text/plain": repr(shown).splitlines(keepends=True)}


if __name__ == "__main__":
    for file in sorted(FOLDER.glob("*.ipynb")):
        done = executed(json.loads(file.read_text("utf-8")))
        file.write_text(json.dumps(done, indent=1, ensure_ascii=False) + "\n", "utf-8")
        print(file)
