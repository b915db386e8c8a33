# SPDX-License-Identifier: Apache-2.0
"""Commands that simulate a scene in time: one run, or many of an operating map or a fit."""
