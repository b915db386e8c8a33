# SPDX-License-Identifier: Apache-2.0
"""Commands on the nodes and on an installation."""
