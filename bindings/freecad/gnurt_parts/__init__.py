# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of the renderer Gnurt: the stage, its lights, its materials."""
