# SPDX-License-Identifier: Apache-2.0
"""Write, read and mend bags: MCAP that `ros2 bag`, Foxglove and PlotJuggler open, readable after kill -9."""
