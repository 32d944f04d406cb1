// Maps floats to integers that compare in the same order, for atomicMin and atomicMax. Twin: reference::twin::fit.
#ifndef MAPS_FLOAT_ORDER_GLSL
#define MAPS_FLOAT_ORDER_GLSL

uint float_order(float value) {
    uint bits = floatBitsToUint(value);
    return (bits >> 31) == 1u ? ~bits : bits | 0x80000000u;
}

float float_of_order(uint order) {
    return uintBitsToFloat((order >> 31) == 1u ? order & 0x7FFFFFFFu : ~order);
}
#endif
