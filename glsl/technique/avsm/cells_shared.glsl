// The two passes of glsl/technique/avsm/cells.comp over a tile's casters, for GPUs. Shared memory holds the casters; several threads per
// texel test them and sum them. Needs the declarations of glsl/technique/avsm/cells.comp. Twin: reference::twin::avsm::cells.
#ifndef TECHNIQUE_AVSM_CELLS_SHARED_GLSL
#define TECHNIQUE_AVSM_CELLS_SHARED_GLSL

// Number of casters that a thread tests before it processes its hits, at most 32. If casters are small, the threads of a subgroup then
// process hits together: the number of iterations is the hit count of the busiest thread, not the number of casters hit by at least one
// thread. If this number is not 1, casters that cannot extend any texel's range are also skipped, and a workgroup must have at least as
// many threads as a batch has casters.
CONSTANT(uint, AHEAD, 1u)

// For this batch and the next: the maximum of low_bits and the minimum of high_bits over all texels, and the number of casters in the
// batch.
shared uint last_low[2];
shared uint first_high[2];
shared uint filled[2];

// Returns whether the caster is a sphere that rays cross along whole chords, with an optical depth below DARK.
bool is_plain(View view, Caster caster) {
    bool wide = !AREA || all(greaterThan(vec2(caster.radius), WIDE * texel_sides(view, 1.0)));
    return wide && plain_sphere(view, caster) && 2.001 * caster.radius * caster.density < DARK;
}

// Stores a caster in the batch. A plain sphere is stored with its squared radius, and with its density in units of optical depth per unit
// of length. Any other caster is stored with its radius negated, which marks it.
void put_caster(View view, uint i, Caster caster, float scale) {
    bool plain = is_plain(view, caster);
    batch[i] = vec4(caster.position, plain ? caster.radius * caster.radius : -caster.radius);
    batch[BATCH + i] = vec4(caster.axis, plain ? caster.density * scale : caster.density);
}

Caster unpack_caster(vec4 ball, uint i) {
    vec4 rest = batch[BATCH + i];
    return Caster(ball.xyz, -ball.w, rest.xyz, rest.w);
}

// Returns the square of half the ray's chord in a plain sphere; 0 or less if the ray misses it.
float half_square(TexelRay its, vec4 ball) {
    vec2 across = ball.xy - its.ray.origin.xy;
    return ball.w - dot(across, across);
}

// Returns one bit per caster that the ray may hit, for casters i, i + GROUPS, … < count of the batch, at most AHEAD of them.
uint hits_ahead(TexelRay its, uint i, uint count) {
    uint hits = 0u;
    for (uint bit = 0u; bit < AHEAD && i < count; ++bit, i += GROUPS) {
        vec4 ball = batch[i];
        bool hit = half_square(its, ball) > 0.0;
        if (ball.w < 0.0) {
            hit = AREA || view_meets(its.view, its.ray, its.ray_length, unpack_caster(ball, i));
        }
        hits |= uint(hit) << bit;
    }
    return hits;
}

void reach_batched(TexelRay its, uint i, inout Reach reach) {
    vec4 ball = batch[i];
    if (ball.w < 0.0) {
        reach_caster(its, unpack_caster(ball, i), reach);
        return;
    }
    float square = half_square(its, ball);
    if (square > 0.0) {
        float half_chord = sqrt(square);
        reach.low = min(reach.low, ball.z - half_chord);
        reach.high = max(reach.high, ball.z + half_chord);
    }
}

// Returns whether the caster may extend any texel's range, or may be opaque.
bool reaches_beyond(View view, Caster caster, uint low, uint high) {
    float reach = caster.radius + 1e-5 * (caster.radius + abs(caster.position.z));
    vec2 depth = (caster.position.z + vec2(-reach, reach) - view.near) / (view.far - view.near);
    return floatBitsToUint(max(depth.x, 0.0)) < low || floatBitsToUint(max(depth.y, 0.0)) + 1u > high ||
           !plain_sphere(view, caster) || 2.001 * caster.radius * caster.density >= DARK;
}

// Same as find_range below, but processes only casters that may extend a range known at the start of their batch.
void find_range_sieved(TexelRay its, TilePart part) {
    uvec2 most = uvec2(0u);
    uint thread = gl_LocalInvocationIndex, group = gl_LocalInvocationID.y;
    if (thread < 2u) {
        last_low[thread] = filled[thread] = 0u;
        first_high[thread] = NEVER;
    }
    for (uint begin = 0u, turn = 0u; begin < part.count; begin += BATCH, ++turn) {
        uint now = turn & 1u;
        bool mine = thread < BATCH && begin + thread < part.count;
        Caster caster;
        if (mine) {
            uvec2 entry = entries[part.first + begin + thread];
            caster = view_caster(its.view, casters[entry.y]);
            wide_add(most, entry_bound(entry, DARK));
        }
        barrier();
        if (group == 0u) {
            atomicMax(last_low[now], low_bits[its.texel]);
            atomicMin(first_high[now], high_bits[its.texel]);
        }
        barrier();
        if (mine && reaches_beyond(its.view, caster, last_low[now], first_high[now])) {
            put_caster(its.view, atomicAdd(filled[now], 1u), caster, 1.0);
        }
        barrier();
        if (thread == 0u) {
            last_low[1u - now] = filled[1u - now] = 0u;
            first_high[1u - now] = NEVER;
        }
        uint count = filled[now];
        Reach reach = Reach(FARTHEST, -FARTHEST, FARTHEST);
        for (uint i = group; i < count; i += AHEAD * GROUPS) {
            for (uint hits = hits_ahead(its, i, count); hits != 0u; hits &= hits - 1u) {
                reach_batched(its, i + uint(findLSB(hits)) * GROUPS, reach);
            }
        }
        share_reach(its, reach);
    }
    WIDE_ATOMIC_ADD(bound[0], bound[1], most);
}

// Finds the depths that each texel's segments span, the depth beyond which it is dark, and a bound on the optical depth in any texel.
void find_range(TexelRay its, TilePart part) {
    if (AHEAD != 1u) {
        find_range_sieved(its, part);
        return;
    }
    uvec2 most = uvec2(0u);
    Reach reach = Reach(FARTHEST, -FARTHEST, FARTHEST);
    for (uint begin = 0u; begin < part.count; begin += BATCH) {
        uint count = min(BATCH, part.count - begin);
        barrier();
        for (uint i = gl_LocalInvocationIndex; i < count; i += THREADS) {
            uvec2 entry = entries[part.first + begin + i];
            wide_add(most, entry_bound(entry, DARK));
            put_caster(its.view, i, view_caster(its.view, casters[entry.y]), 1.0);
        }
        barrier();
        for (uint i = gl_LocalInvocationID.y; i < count; i += GROUPS) {
            reach_batched(its, i, reach);
        }
    }
    barrier();
    share_reach(its, reach);
    WIDE_ATOMIC_ADD(bound[0], bound[1], most);
}

// Adds a caster of the batch to a texel's cells.
void add_batched(TexelRay its, uint i, Range range) {
    vec4 ball = batch[i];
    if (ball.w < 0.0) {
        vec2 at;
        float optical_depth;
        if (caster_within(its, unpack_caster(ball, i), range, at, optical_depth)) {
            float whole = optical_depth * range.scale;
            add_segment(its.texel, at, whole, whole / max(at.y - at.x, 1e-6));
        }
        return;
    }
    float square = half_square(its, ball);
    if (square <= 0.0) {
        return;
    }
    float half_chord = sqrt(square), takes = batch[BATCH + i].w;
    float half_cells = half_chord * range.per_z, middle = (ball.z - its.view.near) * range.per_z - range.low * range.per_cell;
    vec2 at = clamp(vec2(middle - half_cells, middle + half_cells), 0.0, float(CELLS));
    float rate = takes * range.z_per_cell, whole = 2.0 * half_chord * takes;
    if (!range.ends_dark || at.x < float(CELLS)) {
        add_segment(its.texel, at, range.ends_dark ? min(whole, (at.y - at.x) * rate) : whole, rate);
    }
}

void add_casters(TexelRay its, TilePart part, Range range) {
    for (uint begin = 0u; begin < part.count; begin += BATCH) {
        uint count = min(BATCH, part.count - begin);
        barrier();
        for (uint i = gl_LocalInvocationIndex; i < count; i += THREADS) {
            put_caster(its.view, i, tile_caster(its.view, part.first + begin + i), range.scale);
        }
        barrier();
        for (uint i = gl_LocalInvocationID.y; i < count; i += AHEAD * GROUPS) {
            if (AHEAD == 1u) {
                add_batched(its, i, range);
                continue;
            }
            for (uint hits = hits_ahead(its, i, count); hits != 0u; hits &= hits - 1u) {
                add_batched(its, i + uint(findLSB(hits)) * GROUPS, range);
            }
        }
    }
}
#endif
