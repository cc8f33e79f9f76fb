// SPDX-License-Identifier: GPL-3.0-or-later
// Mean free paths below surfaces, from the radius of Blender's nodes.

color b_free_path(color albedo, color radius)
{
    return radius;
}
