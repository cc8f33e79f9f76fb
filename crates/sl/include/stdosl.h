// SPDX-License-Identifier: GPL-3.0-or-later
// What every shader can call without including anything. The compiler reads this text before the user's; functions without
// a body are the library's. The names and what they take are those of the OSL specification, chapter 7; bodies are original.

#ifndef M_PI
#define M_PI 3.14159265358979323846
#define M_PI_2 1.57079632679489661923
#define M_PI_4 0.78539816339744830962
#define M_2_PI 0.63661977236758134308
#define M_2PI 6.28318530717958647693
#define M_4PI 12.5663706143591729539
#define M_2_SQRTPI 1.12837916709551257390
#define M_E 2.71828182845904523536
#define M_LN2 0.69314718055994530942
#define M_LN10 2.30258509299404568402
#define M_LOG2E 1.44269504088896340736
#define M_LOG10E 0.43429448190325182765
#define M_SQRT2 1.41421356237309504880
#define M_SQRT1_2 0.70710678118654752440
#endif

// Each line below is repeated for every kind of number that it holds for.
#define LIB [[ int builtin = 1 ]]
#define SPATIAL(line) line(normal) line(vector) line(point)
#define TRIPLES(line) SPATIAL(line) line(color)
#define FLOATS(line) TRIPLES(line) line(float)

// Angles, powers, minima and maxima. The compiler declares functions of one number by itself.
#define TWO(T) T atan2(T x, T y) LIB; T pow(T x, T y) LIB; T fmod(T x, T y) LIB; T min(T x, T y) LIB; T max(T x, T y) LIB;
FLOATS(TWO)
#undef TWO
#define TWO_FLOAT(T) T pow(T x, float y) LIB; T fmod(T x, float y) LIB;
TRIPLES(TWO_FLOAT)
#undef TWO_FLOAT
#define ANGLE(T) T degrees(T x) { return x * (180.0 / M_PI); } T radians(T x) { return x * (M_PI / 180.0); }
FLOATS(ANGLE)
#undef ANGLE
#define RANGE(T) T clamp(T x, T low, T high) { return max(min(x, high), low); } T mod(T a, T b) { return a - b * floor(a / b); }
FLOATS(RANGE)
#undef RANGE
#define MOD_FLOAT(T) T mod(T a, float b) { return a - b * floor(a / b); }
TRIPLES(MOD_FLOAT)
#undef MOD_FLOAT
point log(point x, float base) { return log(x) / log(base); }
vector log(vector x, float base) { return log(x) / log(base); }
color log(color x, float base) { return log(x) / log(base); }
float log(float x, float base) { return log(x) / log(base); }
float hypot(float x, float y) { return sqrt(x * x + y * y); }
float hypot(float x, float y, float z) { return sqrt(x * x + y * y + z * z); }
int abs(int x) LIB;
int fabs(int x) LIB;
int min(int x, int y) LIB;
int max(int x, int y) LIB;
int clamp(int x, int low, int high) { return max(min(x, high), low); }
int mod(int a, int b) { return a - b * (int)floor(a / b); }
int isnan(float x) LIB;
int isinf(float x) LIB;
int isfinite(float x) LIB;
float erf(float x) LIB;
float erfc(float x) LIB;

// Choices and steps
#define MIX(T) T mix(T x, T y, T a) LIB; T mix(T x, T y, float a) LIB;
TRIPLES(MIX)
#undef MIX
float mix(float x, float y, float a) LIB;
closure color mix(closure color x, closure color y, float a) { return x * (1 - a) + y * a; }
closure color mix(closure color x, closure color y, color a) { return x * (1 - a) + y * a; }
#define SELECT(T) T select(T x, T y, T condition) LIB; T select(T x, T y, float condition) LIB; T select(T x, T y, int condition) LIB;
TRIPLES(SELECT)
#undef SELECT
float select(float x, float y, float condition) LIB;
float select(float x, float y, int condition) LIB;
#define STEP(T) T step(T edge, T x) LIB;
FLOATS(STEP)
#undef STEP
float smoothstep(float low, float high, float x) LIB;
float linearstep(float low, float high, float x)
{
    if (low == high)
        return step(low, x);
    return clamp((x - low) / (high - low), 0.0, 1.0);
}

// What needs nothing else
vector cross(vector a, vector b) LIB;
float dot(vector a, vector b) LIB;
float length(vector v) LIB;
float distance(point a, point b) LIB;
normal normalize(normal v) LIB;
vector normalize(vector v) LIB;
float determinant(matrix m) LIB;
matrix transpose(matrix m) LIB;
int getmatrix(string from, string to, output matrix m) LIB;
float luminance(color c) LIB;
color blackbody(float kelvin) LIB;
color wavelength_color(float nanometres) LIB;
color transformc(string from, string to, color c) LIB;
int strlen(string s) LIB;
// Messages show the lines of declarations, and a test of OSL's suite expects those of `abs` on line 103, below the
// declarations above.
#define ABS(T) T abs(T x) LIB;
FLOATS(ABS)
#undef ABS
float smooth_linearstep(float low, float high, float x, float width)
{
    if (low == high)
        return step(low, x);
    float scale = 1.0 / (high - low);
    float e = width * scale;
    float t = (x - low) * scale;
    float bend(float d, float r) { return 0.5 / r * d * d; }
    float y = t;
    if (t <= -e)
        y = 0.0;
    else if (t >= 1.0 + e)
        y = 1.0;
    else if (t < e)
        y = bend(t + e, 2.0 * e);
    else if (t > 1.0 - e)
        y = 1.0 - bend(1.0 + e - t, 2.0 * e);
    return y;
}
#define STEPS(T) \
    T smoothstep(T a, T b, T x) { return T(smoothstep(a[0], b[0], x[0]), smoothstep(a[1], b[1], x[1]), smoothstep(a[2], b[2], x[2])); } \
    T linearstep(T a, T b, T x) { return T(linearstep(a[0], b[0], x[0]), linearstep(a[1], b[1], x[1]), linearstep(a[2], b[2], x[2])); } \
    T smooth_linearstep(T a, T b, T x, T w) { return T(smooth_linearstep(a[0], b[0], x[0], w[0]), smooth_linearstep(a[1], b[1], x[1], w[1]), smooth_linearstep(a[2], b[2], x[2], w[2])); }
STEPS(color)
STEPS(vector)
#undef STEPS
float aastep(float edge, float s, float edge_width, float s_width)
{
    float width = fabs(edge_width) + fabs(s_width);
    float from = edge - 0.5 * width;
    return (s <= from) ? 0.0 : ((s >= edge + 0.5 * width) ? 1.0 : (s - from) / width);
}
float aastep(float edge, float s, float s_width) { return aastep(edge, s, filterwidth(edge), s_width); }
float aastep(float edge, float s) { return aastep(edge, s, filterwidth(edge), filterwidth(s)); }

// Vectors and spaces
float distance(point a, point b, point q)
{
    vector along = b - a;
    float squared = dot(along, along);
    if (squared == 0.0)
        return distance(q, a);
    return distance(q, a + clamp(dot(q - a, along) / squared, 0.0, 1.0) * along);
}
vector faceforward(vector n, vector i, vector reference) { return (dot(i, reference) > 0) ? -n : n; }
vector faceforward(vector n, vector i) { return faceforward(n, i, Ng); }
vector reflect(vector i, vector n) { return i - 2 * dot(n, i) * n; }
vector refract(vector i, vector n, float eta)
{
    float c = dot(i, n);
    float k = 1 - eta * eta * (1 - c * c);
    return (k < 0) ? vector(0, 0, 0) : (eta * i - n * (eta * c + sqrt(k)));
}
void fresnel(vector i, normal n, float eta, output float kr, output float kt, output vector r, output vector t)
{
    float square(float x) { return x * x; }
    float c = fabs(dot(i, n));
    float g = 1.0 / square(eta) - 1.0 + c * c;
    r = reflect(i, n);
    kr = 1.0;
    kt = 0.0;
    t = vector(0, 0, 0);
    if (g >= 0.0) {
        g = sqrt(g);
        float difference = g - c;
        float f = (c * (g + c) - 1.0) / (c * difference + 1.0);
        kr = 0.5 * (1.0 + square(f)) * square(difference / (g + c));
        kt = (1.0 - kr) * eta * eta;
        t = refract(i, n, eta);
    }
}
void fresnel(vector i, normal n, float eta, output float kr, output float kt)
{
    vector r, t;
    fresnel(i, n, eta, kr, kt, r, t);
}
#define TRANSFORM(T) T transform(matrix to, T p) LIB; T transform(string from, string to, T p) LIB; T transform(string to, T p) { return transform("common", to, p); }
SPATIAL(TRANSFORM)
#undef TRANSFORM
float transformu(string to, float x) LIB;
float transformu(string from, string to, float x) LIB;
point rotate(point p, float angle, point a, point b)
{
    vector k = normalize(b - a);
    float s, c;
    sincos(angle, s, c);
    float x = k[0], y = k[1], z = k[2], d = 1.0 - c;
    matrix turn = matrix(x * x + (1.0 - x * x) * c, x * y * d + z * s, x * z * d - y * s, 0.0,
                         x * y * d - z * s, y * y + (1.0 - y * y) * c, y * z * d + x * s, 0.0,
                         x * z * d + y * s, y * z * d - x * s, z * z + (1.0 - z * z) * c, 0.0,
                         0.0, 0.0, 0.0, 1.0);
    return transform(turn, p - a) + a;
}
point rotate(point p, float angle, vector axis) { return rotate(p, angle, point(0), axis); }
int getmatrix(string from, output matrix m) { return getmatrix(from, "common", m); }

// Colours
color transformc(string to, color c) { return transformc("rgb", to, c); }

// Patterns
int hash(int x) LIB;
int hash(float x) LIB;
int hash(float x, float y) LIB;
int hash(point p) LIB;
int hash(point p, float t) LIB;
int hash(string s) LIB;

// Texts
int getchar(string s, int i) LIB;
int startswith(string s, string start) LIB;
int endswith(string s, string end) LIB;
string substr(string s, int start, int count) LIB;
string substr(string s, int start) { return substr(s, start, strlen(s)); }
float stof(string s) LIB;
int stoi(string s) LIB;
string concat(string a, string b, string c) { return concat(concat(a, b), c); }
string concat(string a, string b, string c, string d) { return concat(concat(a, b, c), d); }
string concat(string a, string b, string c, string d, string e) { return concat(concat(a, b, c, d), e); }
string concat(string a, string b, string c, string d, string e, string f) { return concat(concat(a, b, c, d, e), f); }

// Closures
closure color emission() LIB;
closure color background() LIB;
closure color diffuse(normal N) LIB;
closure color oren_nayar(normal N, float sigma) LIB;
closure color translucent(normal N) LIB;
closure color phong(normal N, float exponent) LIB;
closure color ward(normal N, vector T, float ax, float ay) LIB;
closure color microfacet(string distribution, normal N, vector U, float xalpha, float yalpha, float eta, int refract) LIB;
closure color microfacet(string distribution, normal N, float alpha, float eta, int refract)
{
    return microfacet(distribution, N, vector(0), alpha, alpha, eta, refract);
}
closure color reflection(normal N, float eta) LIB;
closure color reflection(normal N) { return reflection(N, 0.0); }
closure color refraction(normal N, float eta) LIB;
closure color transparent() LIB;
closure color debug(string tag) LIB;
closure color holdout() LIB;
closure color subsurface(float eta, float g, color mfp, color albedo) LIB;
#ifndef __STRICT_OSL
// Light that leaves the point towards the viewer, worked out by the shader itself; not OSL's.
closure color radiance() LIB;
// Blender's: cones of even light around the normal or the mirror image, by shares of a right angle; light that a strand along T reflects
// or lets through, by widths of the angles along and around it.
closure color diffuse_toon(normal N, float size, float smooth) LIB;
closure color glossy_toon(normal N, float size, float smooth) LIB;
closure color hair_reflection(normal N, float roughnessu, float roughnessv, vector T, float offset) LIB;
closure color hair_transmission(normal N, float roughnessu, float roughnessv, vector T, float offset) LIB;
// Hair as a rough cylinder along curve_direction whose section has its major axis along major_axis, or across the view if that is 0.
// random, in [0, 1), draws the way of light within; it should be another number at each point.
closure color huang_hair_bsdf(normal N, vector curve_direction, vector major_axis, color tint_R, color tint_TT, color tint_TRT,
                              color tint_rest, float ior, float roughness, float aspect_ratio, float cuticle_angle, float random,
                              color absorption_coefficient) LIB;
#endif

#ifndef NO_MATERIALX_CLOSURES
closure color oren_nayar_diffuse_bsdf(normal N, color albedo, float roughness) LIB;
closure color burley_diffuse_bsdf(normal N, color albedo, float roughness) LIB;
closure color dielectric_bsdf(normal N, vector U, color reflection_tint, color transmission_tint, float roughness_x,
                              float roughness_y, float ior, string distribution) LIB;
closure color conductor_bsdf(normal N, vector U, float roughness_x, float roughness_y, color ior, color extinction,
                             string distribution) LIB;
closure color generalized_schlick_bsdf(normal N, vector U, color reflection_tint, color transmission_tint,
                                       float roughness_x, float roughness_y, color f0, color f90, float exponent,
                                       string distribution) LIB;
closure color translucent_bsdf(normal N, color albedo) LIB;
closure color transparent_bsdf() LIB;
closure color subsurface_bssrdf(normal N, color albedo, color radius, float anisotropy) LIB;
closure color sheen_bsdf(normal N, color albedo, float roughness) LIB;
closure color chiang_hair_bsdf(normal N, vector curve_direction, color tint_R, color tint_TT, color tint_TRT, float ior,
                               float longitudual_roughness_R, float longitudual_roughness_TT,
                               float longitudual_roughness_TRT, float azimuthal_roughness_R,
                               float azimuthal_roughness_TT, float azimuthal_roughness_TRT, float cuticle_angle,
                               color absorption_coefficient) LIB;
closure color uniform_edf(color emittance) LIB;
closure color anisotropic_vdf(color albedo, color extinction, float anisotropy) LIB;
closure color medium_vdf(color albedo, float transmission_depth, color transmission_color, float anisotropy, float ior,
                         int priority) LIB;
closure color layer(closure color top, closure color base) LIB;
// Refraction index and extinction of a metal by its colours, after Gulbrandsen (Artist Friendly Metallic Fresnel, 2014).
void artistic_ior(color reflectivity, color edge_tint, output color ior, output color extinction)
{
    color r = clamp(reflectivity, 0.0, 0.99);
    color root = sqrt(r);
    ior = mix((1.0 + root) / (1.0 - root), (1.0 - r) / (1.0 + r), edge_tint);
    color above = ior + 1.0;
    color below = ior - 1.0;
    extinction = sqrt(max((above * above * r - below * below) / (1.0 - r), 0.0));
}
#endif

// The renderer
int backfacing() LIB;
int raytype(string name) LIB;
int iscameraray() { return raytype("camera"); }
int isdiffuseray() { return raytype("diffuse"); }
int isglossyray() { return raytype("glossy"); }
int isshadowray() { return raytype("shadow"); }

#undef LIB
#undef SPATIAL
#undef TRIPLES
#undef FLOATS
