# SPDX-License-Identifier: Apache-2.0
"""Page of a report: charts, interactive view, and the files that go into it (`assets/`)."""
