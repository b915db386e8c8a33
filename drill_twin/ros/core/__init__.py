# SPDX-License-Identifier: Apache-2.0
"""What all nodes share: parameters, quality of service, subscriptions, start-up, shutdown."""
