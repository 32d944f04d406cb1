#version 460
// Advances every particle by one step. A particle whose life is over is born again. Any other particle is pulled, slowed, and moved along
// one axis at a time. It bounces off the box and off each occupied voxel that it would enter. One thread per particle. Source: ours, after
// Pestana's GPU particles (2015); pcg: Jarzynski and Olano 2020. Inputs: law, jets, grid. Input and output: bodies. Output: casters.
// Twin: reference::twin::simulate::Rules::step, to the bit: no operation here may be fused or reordered, and only integers are divided.
// Invariants: no particle leaves the box or enters an occupied voxel; after its birth, a particle's state depends only on the step's
// number, not on the step at which the device began.
layout(local_size_x = 64) in;
#include "animate/simulate/law.glsl"
#include "grid/grid.glsl"
#include "world/body.glsl"

layout(push_constant, scalar) uniform StepPush {
    uint step_number;
    uint particles;
    float attractor_x;
    float attractor_y;
    float attractor_z;
};

// set 0: simulate
layout(set = 0, binding = 0, scalar) readonly buffer StepLaw { Law law; };
layout(set = 0, binding = 1, scalar) readonly buffer StepJets { Jet jets[]; };
layout(set = 0, binding = 2, scalar) readonly buffer StepGrid { Grid grid; };
layout(set = 0, binding = 3, scalar) readonly buffer StepBits { uint grid_bits[]; };
layout(set = 0, binding = 4, scalar) buffer StepBodies { Body bodies[]; };
// Two vec4s per caster, so that each caster is written with two vector stores.
layout(set = 0, binding = 5, scalar) writeonly buffer StepCasters { vec4 casters[]; };

uint pcg(uint value) {
    uint state = value * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Converts a 16-bit integer to bits / 2¹⁶, exactly.
float share_of(uint bits) { return float(bits) * (1.0 / 65536.0); }

// Returns a particle at its birth. Each random word is the hash of the previous word; the first chooses the jet.
Body birth(uint particle, uint births) {
    uint word = pcg(pcg(particle ^ pcg(births)));
    Jet jet = jets[word & 7u];
    uint words[6];
    for (uint i = 0u; i < 6u; ++i) {
        word = pcg(word);
        words[i] = word;
    }
    vec3 place = vec3(share_of(words[0] >> 16), share_of(words[1] >> 16), share_of(words[2] >> 16));
    vec3 first = vec3(share_of(words[3] & 0xFFFFu), share_of(words[4] & 0xFFFFu), share_of(words[5] & 0xFFFFu));
    vec3 second = vec3(share_of(words[3] >> 16), share_of(words[4] >> 16), share_of(words[5] >> 16));
    precise vec3 position = jet.position + jet.width * (place - 0.5);
    precise vec3 speed = jet.speed + jet.spread * ((first + second) - 1.0);
    precise float radius = law.radius * (0.625 + 0.375 * share_of(words[0] & 0xFFFFu));
    return Body(vec4(position, radius), vec4(speed, law.extinction));
}

ivec3 voxel_of(vec3 position) {
    precise vec3 voxels = (position - grid.origin) * grid.per_unit;
    return ivec3(floor(voxels));
}

bool has(ivec3 voxel) {
    if (any(lessThan(voxel, ivec3(0))) || any(greaterThanEqual(voxel, ivec3(grid.size)))) {
        return false;
    }
    uint bit = grid_bit(0u, uvec3(voxel));
    return (grid_bits[2u * grid_word(grid.size, 0u, uvec3(voxel)) + (bit >> 5)] >> (bit & 31u) & 1u) == 1u;
}

// Returns whether a move along one axis enters an occupied voxel.
bool is_met(vec3 from, uint axis, float to) {
    ivec3 voxel = voxel_of(from);
    vec3 end = from;
    end[axis] = to;
    int last = voxel_of(end)[axis];
    while (voxel[axis] != last) {
        voxel[axis] += sign(last - voxel[axis]);
        if (has(voxel)) {
            return true;
        }
    }
    return false;
}

void go(inout Body body) {
    vec3 position = body.place.xyz;
    precise vec3 way = vec3(attractor_x, attractor_y, attractor_z) - position;
    precise float square = way.x * way.x + way.y * way.y + way.z * way.z;
    precise float near = 1.0 - square * law.reach;
    precise float pull = near > 0.0 ? law.pull * near : 0.0;
    precise vec3 speed = ((body.speed.xyz + pull * way) - vec3(0.0, 0.0, law.gravity)) * law.drag;
    speed = clamp(speed, vec3(-law.fastest), vec3(law.fastest));
    speed = mix(speed, vec3(0.0), lessThan(abs(speed), vec3(law.rest)));
    for (uint axis = 0u; axis < 3u; ++axis) {
        precise float to = position[axis] + speed[axis];
        if (to < law.low[axis] || to > law.high[axis] || is_met(position, axis, to)) {
            vec3 kept = vec3(law.slide);
            kept[axis] = -law.bounce;
            speed *= kept;
        } else {
            position[axis] = to;
        }
    }
    body.place.xyz = position;
    body.speed.xyz = speed;
}

void main() {
    uint particle = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (particle >= particles) {
        return;
    }
    uint at = step_number + pcg(particle) % law.life;
    uint age = at % law.life;
    Body body = bodies[particle];
    if (age == 0u) {
        body = birth(particle, at / law.life);
    } else {
        go(body);
    }
    bodies[particle] = body;
    precise float appear = float(age + 1u) * law.appear;
    precise float vanish = float(law.life - age) * law.vanish;
    precise float extinction = body.speed.w * min(min(appear, vanish), 1.0);
    casters[2u * particle] = body.place;
    casters[2u * particle + 1u] = vec4(0.0, 0.0, 0.0, extinction);
}
