// Roots of polynomials that have real ones only. Twin: reference::twin::moments.
#ifndef TECHNIQUE_MOMENTS_ROOTS_GLSL
#define TECHNIQUE_MOMENTS_ROOTS_GLSL

// The most that a polynomial has.
const uint MOST_ROOTS = 4u;

// Steps of largest_root.
const uint ROUNDS = 5u;

// The largest root of u^n + all[0] u^(n-1) + …: Laguerre's method from above, which never passes it.
float largest_root(float all[MOST_ROOTS], uint n) {
    float order = float(n);
    float spread = sqrt(max(all[0] * all[0] - 2.0 * order / (order - 1.0) * all[1], 0.0));
    float u = -all[0] / order + (order - 1.0) / order * spread;
    for (uint i = 0u; i < ROUNDS; ++i) {
        float value = 1.0, slope = 0.0, bend = 0.0;
        for (uint k = 0u; k < n; ++k) {
            bend = bend * u + slope;
            slope = slope * u + value;
            value = value * u + all[k];
        }
        float under = (order - 1.0) * ((order - 1.0) * slope * slope - 2.0 * order * value * bend);
        float over = slope + sqrt(max(under, 0.0));
        u -= over > 0.0 ? order * value / over : 0.0;
    }
    return u;
}

// All roots of u^n + …, the largest first; n is at least 2.
void real_roots(float all[MOST_ROOTS], uint n, out float roots[MOST_ROOTS]) {
    for (uint degree = n; degree > 2u; --degree) {
        float root = largest_root(all, degree), carried = 1.0;
        roots[n - degree] = root;
        // Divided by what has that root.
        for (uint k = 0u; k < degree; ++k) {
            carried = carried * root + all[k];
            all[k] = carried;
        }
    }
    float middle = -0.5 * all[0], spread = sqrt(max(middle * middle - all[1], 0.0));
    float far = middle < 0.0 ? middle - spread : middle + spread;
    float near = far != 0.0 ? all[1] / far : 0.0;
    roots[n - 2u] = max(far, near);
    roots[n - 1u] = min(far, near);
}
#endif
