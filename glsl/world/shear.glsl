// A ray as a shear that aligns it with the z axis, and what a triangle looks like from there. Source: Woop et al. 2013, Watertight
// ray/triangle intersection. Twin: reference::twin::sheet.
#ifndef WORLD_SHEAR_GLSL
#define WORLD_SHEAR_GLSL

// A ray, as the shear that aligns it with the z axis and moves its origin to 0. `axis`: the world axis along which the ray is longest.
// `by`: its slopes along the other two axes.
struct Shear {
    vec3 origin;
    uint axis;
    vec3 by;  // the two slopes, and length of the ray per unit along the axis
};

vec3 shear_turned(vec3 v, uint axis) { return axis == 0u ? v.yzx : axis == 1u ? v.zxy : v; }

Shear shear_of(vec3 origin, vec3 direction) {
    vec3 far = abs(direction);
    uint axis = far.x >= far.y && far.x >= far.z ? 0u : far.y >= far.z ? 1u : 2u;
    vec3 turned = shear_turned(direction, axis);
    return Shear(origin, axis, vec3(turned.xy / turned.z, 1.0 / turned.z));
}

// A corner relative to the ray. x and y: its offset from the ray; z: its position along the ray, in lengths of the ray's direction.
vec3 sheared(Shear shear, vec3 corner) {
    precise vec3 v = shear_turned(corner - shear.origin, shear.axis);
    precise vec2 beside = v.xy - shear.by.xy * v.z;
    return vec3(beside, v.z * shear.by.z);
}

// Twice the signed area of the triangle that the ray, at the origin, forms with an edge. The mesh triangle on the other side traverses that
// edge in the opposite direction and gets exactly the negated value, bit for bit. So no ray slips through between the two mesh triangles.
float side_area(vec2 from, vec2 to) {
    precise float area = from.x * to.y - from.y * to.x;
    return area;
}
#endif
