# SPDX-License-Identifier: Apache-2.0
"""Pictures of the README and the introduction that no command of the package draws."""
