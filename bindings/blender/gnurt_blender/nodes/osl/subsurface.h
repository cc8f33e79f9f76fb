// SPDX-License-Identifier: GPL-3.0-or-later
// Colours and mean free paths of walks below surfaces, from the colours and radii of Blender's nodes: fitted to pictures of Cycles.

// The colour of a random walk; below a gloss pictures of Cycles are darker.
color b_walk_color(color albedo, float gloss)
{
    return albedo * (color(1) - (0.06 + 0.075 * gloss) * (color(1) - albedo));
}
// Its mean free path.
color b_walk_path(color albedo, color radius)
{
    return radius * (color(0.0525) + 0.042 * albedo);
}
// The colour of a walk of bent light, which enters deeper.
color b_skin_color(color albedo, float gloss)
{
    return albedo * (color(1) + (0.165 - 0.075 * gloss) * (color(1) - albedo));
}
// The mean free path of a random walk for skin, with the root of the albedo's rest of [KC17], as the renderer's walks: its radius is about the distance that light diffuses.
color b_skin_path(color albedo, color radius)
{
    color s = color(4.09712) + 4.20863 * albedo - sqrt(color(9.59217) + 41.6808 * albedo + 17.7126 * albedo * albedo);
    return 0.5 * radius * sqrt(3.0 * max(s * s, color(1e-6)));
}
