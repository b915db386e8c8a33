# SPDX-License-Identifier: Apache-2.0
"""The process itself: environment of children, standard streams, lost exceptions."""
