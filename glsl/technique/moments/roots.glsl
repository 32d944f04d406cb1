// Roots of polynomials that have only real roots. Twin: reference::twin::roots.
#ifndef TECHNIQUE_MOMENTS_ROOTS_GLSL
#define TECHNIQUE_MOMENTS_ROOTS_GLSL

// Maximum number of roots of a polynomial.
const uint MOST_ROOTS = 4u;

// Number of Laguerre steps per root.
const uint ROUNDS = 5u;

// Values nearer to 0 count as 0.
const float LEAST_ROOT = 1e-6;

// Returns the largest root of the polynomial u^n + all[0] u^(n-1) + …, whose roots all lie between -1 and 1. Laguerre's method converges
// from above and never passes the largest root.
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

// Finds all roots of u^n + …, those far from 0 first, so that the deflated polynomial is accurate near 0; n is at least 2.
void real_roots(float all[MOST_ROOTS], uint n, out float roots[MOST_ROOTS]) {
    for (uint i = 0u; i < MOST_ROOTS; ++i) {
        roots[i] = 0.0;
    }
    for (uint degree = n; degree > 2u; --degree) {
        // The sum of the roots' squares bounds each root. The polynomial is mirrored if the roots' sum is negative, so that a root much
        // farther from 0 than the others is the largest.
        float square = all[0] * all[0];
        float bound = sqrt(max(square - 2.0 * all[1], square / float(degree)));
        if (bound < LEAST_ROOT) {
            break;
        }
        float unit = all[0] > 0.0 ? -bound : bound, power = 1.0;
        for (uint k = 0u; k < degree; ++k) {
            power /= unit;
            all[k] *= power;
        }
        float root = largest_root(all, degree), carried = 0.0;
        roots[n - degree] = unit * root;
        // Deflation: divides the polynomial by (u − root), starting from the last coefficient.
        for (uint k = degree - 1u; k > 0u; --k) {
            carried = root > 0.0 ? (carried - all[k]) / root : 0.0;
            all[k] = carried;
        }
        power = 1.0;
        for (uint k = 1u; k < degree; ++k) {
            power *= unit;
            all[k - 1u] = all[k] * power;
        }
    }
    float middle = -0.5 * all[0], spread = sqrt(max(middle * middle - all[1], 0.0));
    float far = middle < 0.0 ? middle - spread : middle + spread;
    roots[n - 2u] = far;
    roots[n - 1u] = abs(far) > LEAST_ROOT ? all[1] / far : 0.0;
}
#endif
