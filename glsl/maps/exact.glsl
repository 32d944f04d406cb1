// Reciprocals by Newton's method from an initial guess that is computed in integers. They use only products and sums, which every device
// rounds in the same way, while Vulkan lets a quotient be wrong by 2.5 units in the last place. The reciprocals' error bound is two units
// in the last place. Twin:
// reference::twin::exact.
#ifndef MAPS_EXACT_GLSL
#define MAPS_EXACT_GLSL

// Arguments of smaller or larger magnitude are clamped to these limits.
const float EXACT_LEAST = 1e-36;
const float EXACT_MOST = 1e36;

// 1 / a for a non-negative `a`.
float reciprocal(float a) {
    float of = clamp(a, EXACT_LEAST, EXACT_MOST);
    precise float guess = uintBitsToFloat(0x7ef311c7u - floatBitsToUint(of));
    guess = guess * (2.0 - of * guess);
    guess = guess * (2.0 - of * guess);
    guess = guess * (2.0 - of * guess);
    return guess;
}

float dot3(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

// Upper bound of a vector's length, at most 25 % above the length.
float longest3(vec3 a) {
    vec3 along = abs(a);
    float most = max(along.x, max(along.y, along.z));
    precise float bound = most + 0.5 * (along.x + along.y + along.z - most);
    return bound;
}

vec3 cross3(vec3 a, vec3 b) {
    precise vec3 product = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return product;
}
#endif
