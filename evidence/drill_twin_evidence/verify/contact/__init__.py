# SPDX-License-Identifier: Apache-2.0
"""Cases of contact: wall, bit-rock interaction, stick-slip."""
