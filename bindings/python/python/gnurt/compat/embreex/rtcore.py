# SPDX-License-Identifier: GPL-3.0-or-later
"""embreex.rtcore."""

__all__ = ["EmbreeDevice"]


class EmbreeDevice:
    """Nothing is kept in a device."""

    def __repr__(self):
        import gnurt

        return f"EmbreeDevice(GNU RT {gnurt.__version__})"
