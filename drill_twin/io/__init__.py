# SPDX-License-Identifier: Apache-2.0
"""Messages and bags: the bytes on topics and in files."""
