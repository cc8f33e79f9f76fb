# SPDX-License-Identifier: GPL-3.0-or-later
"""Warnings of an export: each names a node, an object or a setting, and appears once."""


class Warned:
    """Collects warnings in the order in which they appear."""

    def __init__(self):
        self.lines = []

    def __call__(self, line):
        if line not in self.lines:
            self.lines.append(line)
