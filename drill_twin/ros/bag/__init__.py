# SPDX-License-Identifier: Apache-2.0
"""Recorder and replayer nodes."""
