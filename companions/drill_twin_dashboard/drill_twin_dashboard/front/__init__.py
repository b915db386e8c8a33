# SPDX-License-Identifier: Apache-2.0
"""The front door: a page on the scenes and results of a folder, whose forms run the commands of `drill-twin`."""
