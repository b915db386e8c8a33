# SPDX-License-Identifier: Apache-2.0
"""Limits of this machine: multiply-adds per second on one core, and the solver's share of that."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from drill_twin.core.compile.jit import FLAGS
from drill_twin.dynamics.solver.spatial.linear_solver import NODE, ROW, solve_blocks

LANES = 8
CHAINS = 12
ROUNDS = 20_000_000
REPEATS = 7


@njit(fastmath=True, error_model="numpy")
def multiply_add(values: Any, rounds: int) -> None:
    """Independent multiply-adds on values that fit the vector registers: CHAINS * LANES of them a round."""
    for i in range(values.size):
        x = values[i]
        for _ in range(rounds):
            x = x * 0.9999999 + 1e-7
        values[i] = x


@njit(fastmath=True, error_model="numpy")
def multiply_add_wide(values: Any, rounds: int) -> None:
    """As `multiply_add`, with the rounds outside, so that the values move through vector instructions together."""
    for _ in range(rounds):
        for i in range(CHAINS * LANES):
            values[i] = values[i] * 0.9999999 + 1e-7


@njit(**FLAGS)  # type: ignore[untyped-decorator]
def solve(lower: Any, diagonal: Any, upper: Any, spare: Any) -> bool:
    """The solver of one Newton step by itself."""
    return bool(solve_blocks(lower, diagonal, upper, spare))


def least_seconds(work: Callable[[], object]) -> float:
    """Shortest processor time of a few calls [s]; the first, which compiles, is left out."""
    work()
    spent = []
    for _ in range(REPEATS):
        began = time.process_time()
        work()
        spent.append(time.process_time() - began)
    return min(spent)


def peak_gigaflops() -> float:
    """Multiply-adds in vector registers, two operations each [GFLOP/s]."""
    values = np.linspace(0.0, 1.0, CHAINS * LANES)
    rounds = ROUNDS // 10
    best = min(
        least_seconds(lambda: multiply_add_wide(values, rounds)), least_seconds(lambda: multiply_add(values, rounds))
    )
    return 2.0 * values.size * rounds / best * 1e-9


def solve_flops() -> int:
    """Operations of the block solve per element: factor, two eliminations and substitution of 7 x 7 blocks."""
    n = NODE
    combine = 2 * n * n * (n + 1)  # lower times the eliminated upper block and right-hand side
    eliminate = sum((n - 1 - k) * (1 + 2 * (n - k) + 2 * (n + 1)) for k in range(n))
    back = sum(n + 1 + 2 * (n + 1) * k for k in range(n))
    return combine + eliminate + back + 2 * n * n


def solve_nanoseconds(elements: int = 200, repeats: int = 50) -> float:
    """Time of the block solve per element [ns], on a system like that of a step."""
    random = np.random.default_rng(1)
    blocks = [0.1 * random.standard_normal((count, NODE, ROW)) for count in (elements, elements + 1, elements)]
    blocks[1][:, np.arange(NODE), np.arange(NODE)] += 2.0
    work, spare = [block.copy() for block in blocks], np.zeros((NODE, ROW))

    def fill() -> None:
        for _ in range(repeats):
            for target, source in zip(work, blocks, strict=True):
                target[...] = source

    def fill_and_solve() -> None:
        for _ in range(repeats):
            for target, source in zip(work, blocks, strict=True):
                target[...] = source
            solve(work[0], work[1], work[2], spare)

    return (least_seconds(fill_and_solve) - least_seconds(fill)) / repeats / elements * 1e9
