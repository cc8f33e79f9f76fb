// SPDX-License-Identifier: GPL-3.0-or-later
// Rows of bricks with mortar between them, tinted at random.
float b_brick_random(int n)
{
    int a = (n + 1013) & 2147483647;
    a = (a >> 13) ^ a;
    int b = (a * (a * a * 60493 + 19990303) + 1376312589) & 2147483647;
    return 0.5 * (float(b) / 1073741824.0);
}
void b_brick(vector p, float mortar_size, float mortar_smooth, float bias, float width, float height, float shift, int shift_every,
    float squash, int squash_every, output float tint, output float mortar)
{
    int row = int(floor(p[1] / height));
    float w = width, offset = 0.0;
    if (shift_every && squash_every) {
        w *= (row % squash_every) ? 1.0 : squash;
        offset = (row % shift_every) ? 0.0 : w * shift;
    }
    int brick = int(floor((p[0] + offset) / w));
    float x = p[0] + offset - w * brick, y = p[1] - height * row;
    tint = clamp(b_brick_random((row << 16) + (brick & 65535)) + bias, 0.0, 1.0);
    float near = min(min(x, y), min(w - x, height - y));
    if (near >= mortar_size)
        mortar = 0.0;
    else if (mortar_smooth == 0.0)
        mortar = 1.0;
    else {
        float t = 1.0 - near / mortar_size;
        mortar = (t < mortar_smooth) ? smoothstep(0.0, mortar_smooth, t) : 1.0;
    }
}
