# SPDX-License-Identifier: Apache-2.0
"""Energy of a state, and the ledger of work that a compiled step keeps."""
