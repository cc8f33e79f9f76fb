// SPDX-License-Identifier: GPL-3.0-or-later
// Colours of hot bodies and of single wavelengths, in linear Rec. 709.
// Cubics in 1000 / temperature, fitted to pictures; below 800 K and above 12,000 K the colour stays.
color b_cubic(float x, color a, color b, color c, color d) { return ((a * x + b) * x + c) * x + d; }
color b_blackbody(float kelvin)
{
    float t = clamp(kelvin, 800.0, 12000.0);
    float x = 1000.0 / t;
    color c;
    if (t < 1975.0)
        c = b_cubic(x, color(-0.546376, 0.377699, -5.32597), color(0.249751, -0.631119, 10.61), color(4.74889, -0.930496, -7.47307),
                    color(0.149821, 1.223, 1.7702));
    else if (t < 4500.0)
        c = b_cubic(x, color(-3.21967, 2.28278, -12.2192), color(4.35916, -3.4014, 19.7841), color(2.56138, 0.445317, -11.5491),
                    color(0.5516, 0.989374, 2.37564));
    else
        c = b_cubic(x, color(-11.7249, 1.80127, 11.1273), color(10.351, -3.72251, 8.9591), color(1.13048, 0.650515, -10.15),
                    color(0.666909, 0.965097, 2.34435));
    return max(c, color(0));
}
color b_wavelength(float nanometres)
{
    color c = wavelength_color(nanometres);
    return max(c, color(0));
}
