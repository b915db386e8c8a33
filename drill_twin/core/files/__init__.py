# SPDX-License-Identifier: Apache-2.0
"""Files: bounded readers, whole files, records that go on after a break."""
