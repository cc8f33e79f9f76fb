// SPDX-License-Identifier: GPL-3.0-or-later
// Colours of hot bodies and of single wavelengths, in linear Rec. 709.
color b_blackbody(float kelvin)
{
    // Black bodies below 800 K are black to the eye, and beyond 12,000 K change no more.
    float t = clamp(kelvin, 800.0, 12000.0);
    color c = blackbody(t);
    float y = luminance(c);
    return (y > 0.0) ? c / y : color(0);
}
color b_wavelength(float nanometres)
{
    color c = wavelength_color(nanometres);
    return max(c, color(0));
}
