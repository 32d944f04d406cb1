// Computes the share of a ray's optical depth that lies before a place, from its moments. Many distributions of optical depth have the same
// moments. The tightest bounds come from the distribution with weight at the fewest places, the queried place among them (Markov's
// problem). The other places of this distribution are the roots of a polynomial. The weight of a place is one over a sum of squares, so
// that the bounds stay within 0 to 1 despite rounding. Twin: reference::twin::moments.
#ifndef TECHNIQUE_MOMENTS_SHARE_GLSL
#define TECHNIQUE_MOMENTS_SHARE_GLSL
#include "technique/moments/parts.glsl"
#include "technique/moments/roots.glsl"

CONSTANT(float, OVERESTIMATION, 0.45)  // 0: the lower bound, 1: the upper

// Number of roots.
const uint DEGREE = MOMENTS / 2u;

// Smallest pivot used as a divisor.
const float LEAST_PIVOT = 1e-5;

// Two places count as one if the square of their directions' difference is below this.
const float SAME = 1e-6;

const uint MOST = MOST_ROOTS + 1u;
const uint MOST_MEANS = 2u * MOST_ROOTS + 1u;

// Returns twice the order of half-order basis function i on the circle, and whether the function is a sine.
uvec2 half_function(uint i) {
    return DEGREE % 2u == 1u ? uvec2(1u + 2u * (i / 2u), i % 2u)
                             : uvec2(2u * ((i + 1u) / 2u), i > 0u && i % 2u == 0u ? 1u : 0u);
}

// Evaluates the half-order basis functions at a place, which is given as x over y on the line, as cosine and sine of the half angle on the
// circle.
void half_functions(vec2 place, out float all[MOST]) {
    if (TRIGONOMETRIC) {
        vec2 whole = turned(place, place), at = DEGREE % 2u == 1u ? place : vec2(1.0, 0.0);
        for (uint i = 0u; i <= DEGREE; ++i) {
            uvec2 f = half_function(i);
            if (i > 0u && f.x != half_function(i - 1u).x) {
                at = turned(at, whole);
            }
            all[i] = f.y == 1u ? at.y : at.x;
        }
        return;
    }
    all[0] = 1.0;
    all[1] = place.x;
    for (uint i = 2u; i <= DEGREE; ++i) {
        all[i] = 2.0 * place.x * all[i - 1u] - place.y * place.y * all[i - 2u];
    }
    float scale = 1.0;
    for (uint i = 0u; i <= DEGREE; ++i) {
        all[DEGREE - i] *= scale;
        scale *= place.y;
    }
}

// Returns the means of cos and sin of order k on the circle.
vec2 circle_mean(float means[MOST_MEANS], uint k) {
    if (k == 0u) {
        return vec2(1.0, 0.0);
    }
    return vec2(means[2u * k - 1u], means[2u * k]);
}

// Returns the mean of the product of two half-order basis functions.
float product_mean(float means[MOST_MEANS], uint i, uint j) {
    if (!TRIGONOMETRIC) {
        return 0.5 * (means[i + j] + means[i > j ? i - j : j - i]);
    }
    uvec2 f = half_function(i), g = half_function(j);
    vec2 apart = circle_mean(means, (f.x > g.x ? f.x - g.x : g.x - f.x) / 2u);
    vec2 together = circle_mean(means, (f.x + g.x) / 2u);
    if (f.y == g.y) {
        return 0.5 * (f.y == 0u ? apart.x + together.x : apart.x - together.x);
    }
    // The sine of a difference has the difference's sign.
    uint of_sine = f.y == 1u ? f.x : g.x;
    return 0.5 * (together.y + (2u * of_sine >= f.x + g.x ? apart.y : -apart.y));
}

// Multiplies a vector by the inverse of the lower triangular matrix.
void solve(float lower[MOST * MOST], inout float all[MOST]) {
    for (uint i = 0u; i <= DEGREE; ++i) {
        for (uint k = 0u; k < i; ++k) {
            all[i] -= lower[i * MOST + k] * all[k];
        }
        all[i] /= lower[i * MOST + i];
    }
}

float square_of(float all[MOST]) {
    float square = 0.0;
    for (uint i = 0u; i <= DEGREE; ++i) {
        square += all[i] * all[i];
    }
    return square;
}

// Returns a cos + b sin, shifted to a place with the given cos and sin.
vec2 about(float a, float b, vec2 at) { return vec2(a * at.x + b * at.y, b * at.x - a * at.y); }

// Computes the polynomial whose roots u are the other places of the distribution. A root u is the place at the distance 1 / u from `place`;
// with TRIGONOMETRIC, the place on the circle at an angle from `place` whose half has the cotangent u. `all`: the coefficients in order of
// falling powers, without the first, times `scale`.
void around(float c[MOST], vec2 place, float scale, out float all[MOST_ROOTS]) {
    if (TRIGONOMETRIC) {
        vec2 whole = turned(place, place);
        if (DEGREE == 2u) {
            vec2 a = about(c[1], c[2], whole);
            all[0] = 2.0 * a.y;
            all[1] = c[0] - a.x;
        } else if (DEGREE == 3u) {
            vec2 a = about(c[0], c[1], place), b = about(c[2], c[3], turned(whole, place));
            all[0] = a.y + 3.0 * b.y;
            all[1] = a.x - 3.0 * b.x;
            all[2] = a.y - b.y;
        } else {
            vec2 a = about(c[1], c[2], whole), b = about(c[3], c[4], turned(whole, whole));
            all[0] = 2.0 * a.y + 4.0 * b.y;
            all[1] = 2.0 * c[0] - 6.0 * b.x;
            all[2] = 2.0 * a.y - 4.0 * b.y;
            all[3] = c[0] - a.x + b.x;
        }
    } else {
        float x = place.x, s = x * x;
        all[0] = c[1] + c[2] * 4.0 * x;
        all[1] = 2.0 * c[2];
        if (DEGREE >= 3u) {
            all[0] += c[3] * (12.0 * s - 3.0);
            all[1] += c[3] * 12.0 * x;
            all[2] = c[3] * 4.0;
        }
        if (DEGREE >= 4u) {
            all[0] += c[4] * x * (32.0 * s - 16.0);
            all[1] += c[4] * (48.0 * s - 8.0);
            all[2] += c[4] * 32.0 * x;
            all[3] = c[4] * 8.0;
        }
    }
    for (uint i = 0u; i < DEGREE; ++i) {
        all[i] *= scale;
    }
}

// Returns the share before a place of the range, 0 to 1. `means`: means of the functions, the first of which is 1.
float moments_share(float means[MOST_MEANS], float place) {
    float lower[MOST * MOST], c[MOST], around_it[MOST_ROOTS], roots[MOST_ROOTS];
    for (uint i = 0u; i <= DEGREE; ++i) {
        for (uint j = 0u; j <= i; ++j) {
            float rest = product_mean(means, i, j);
            for (uint k = 0u; k < j; ++k) {
                rest -= lower[i * MOST + k] * lower[j * MOST + k];
            }
            lower[i * MOST + j] = i == j ? sqrt(max(rest, LEAST_PIVOT)) : rest / lower[j * MOST + j];
        }
    }
    vec2 here = TRIGONOMETRIC ? cis(0.5 * ARC * place) : vec2(2.0 * place - 1.0, 1.0);
    half_functions(here, c);
    solve(lower, c);
    // Each place of the distribution has a vector, and these vectors are orthogonal to one another. If rounding splits a place in two, the
    // two share its weight. `directions`: the unit vector of each place. `ones`: the square root of each place's weight.
    float directions[MOST * MOST], ones[MOST];
    float own = 1.0 / max(square_of(c), LEAST_PIVOT);
    for (uint k = 0u; k <= DEGREE; ++k) {
        directions[k] = c[k] * sqrt(own);
    }
    ones[0] = sqrt(own);
    // Multiplies by the inverse of the transposed triangular matrix.
    for (uint down = 0u; down <= DEGREE; ++down) {
        uint i = DEGREE - down;
        for (uint k = i + 1u; k <= DEGREE; ++k) {
            c[i] -= lower[k * MOST + i] * c[k];
        }
        c[i] /= lower[i * MOST + i];
    }
    around(c, here, own, around_it);
    real_roots(around_it, DEGREE, roots);
    float before = OVERESTIMATION * own, all = own;
    for (uint i = 0u; i < DEGREE; ++i) {
        float u = roots[i], one = 1.0, is_before, there[MOST];
        if (TRIGONOMETRIC) {
            half_functions(turned(here, vec2(u, 1.0) / sqrt(u * u + 1.0)), there);
            // Distance of the other place behind this one, in turns of the circle. On the arc from the range's end to its beginning, the
            // other place counts partly as before this one and partly as behind it.
            float turns = atan(1.0, u) / PI;
            is_before = clamp((turns + ARC * place - ARC) / (1.0 - ARC), 0.0, 1.0);
        } else {
            float long_ = max(abs(u), 1.0), y = u / long_;
            half_functions(vec2((here.x * u + 1.0) / long_, y), there);
            for (uint k = 0u; k < DEGREE; ++k) {
                one *= y;
            }
            is_before = u < 0.0 ? 1.0 : 0.0;
        }
        solve(lower, there);
        float least = SAME * square_of(there);
        for (uint j = 0u; j <= i; ++j) {
            float along = 0.0;
            for (uint k = 0u; k <= DEGREE; ++k) {
                along += there[k] * directions[j * MOST + k];
            }
            for (uint k = 0u; k <= DEGREE; ++k) {
                there[k] -= along * directions[j * MOST + k];
            }
            one -= along * ones[j];
        }
        float square = square_of(there);
        bool is_new = square > least;
        float scale = is_new ? 1.0 / sqrt(square) : 0.0;
        for (uint k = 0u; k <= DEGREE; ++k) {
            directions[(i + 1u) * MOST + k] = there[k] * scale;
        }
        ones[i + 1u] = one * scale;
        float weight = ones[i + 1u] * ones[i + 1u];
        all += weight;
        before += weight * is_before;
    }
    return before / all;
}
#endif
