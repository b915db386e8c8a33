# SPDX-License-Identifier: Apache-2.0
"""Bags: written as MCAP that `ros2 bag`, Foxglove and PlotJuggler open, and readable after kill -9."""
