# SPDX-License-Identifier: Apache-2.0
"""Files that Drillbotics asks for, and the check of them."""
