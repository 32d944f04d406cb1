// Paints a part of a tile's casters from near to far, one thread per pixel, and stops when nothing behind is visible. A thread finds the
// next caster that its pixel sees before it shades, so that threads shade different casters at the same time. A part that is its tile's
// whole list is painted over the picture directly; compose.comp combines the other parts. Must be declared before inclusion: light_within,
// the light at a point in a caster. Twin: reference::truth::picture.
#ifndef CONSUME_PAINTER_PAINT_GLSL
#define CONSUME_PAINTER_PAINT_GLSL

layout(local_size_x = 64) in;

// Whether a workgroup reads casters once for all its pixels; otherwise each pixel reads them, and none waits for another.
CONSTANT(bool, STAGED, true)
// Whether consecutive workgroups paint parts from all over the picture: see paint_order.
CONSTANT(bool, SPREAD, false)

// Casters on stage: the pixels that they may cover; positions and radii; axes and densities; indices.
shared uvec2 staged_boxes[TILE_PIXELS];
shared vec4 staged_places[TILE_PIXELS];
shared vec4 staged_axes[TILE_PIXELS];
shared uint staged_numbers[TILE_PIXELS];
// Not 0 while any pixel sees something behind the staged casters.
shared uint seeing;

void put_on_stage(uint i, uint entry) {
    uint number = items[totals.sorted + entry].index;
    Caster caster = casters[number];
    staged_boxes[i] = boxes[number];
    staged_places[i] = vec4(caster.position, caster.radius);
    staged_axes[i] = vec4(caster.axis, caster.density);
    staged_numbers[i] = number;
}

uint listed_number(uint first, uint i) { return STAGED ? staged_numbers[i] : items[totals.sorted + first + i].index; }

Caster listed_caster(uint i, uint number) {
    if (STAGED) {
        return Caster(staged_places[i].xyz, staged_places[i].w, staged_axes[i].xyz, staged_axes[i].w);
    }
    return casters[number];
}

bool may_cover(uint i, uint number, uvec2 pixel) {
    uvec2 box = STAGED ? staged_boxes[i] : boxes[number];
    return all(greaterThanEqual(pixel, both(box.x))) && all(lessThanEqual(pixel, both(box.y)));
}

// Index of the part that a workgroup paints. On devices where each thread runs a row of workgroups (llvmpipe), parts are reordered so that
// every thread gets parts from all over the picture.
uint paint_order(uint listed, uint all) {
    if (!SPREAD) {
        return listed;
    }
    uint rows = min(all, 64u), whole = all / rows * rows;
    return listed < whole ? listed % rows * (all / rows) + listed / rows : listed;
}

// Fraction of each color of light that a caster absorbs between z.x and z.y.
vec3 opacity_of(Ray ray, Caster caster, uint number, vec2 z) {
    vec3 densities = vec3(caster.density);
    if (CASTER_ROOM != 0u) {
        densities.yz = vec2(casters[CASTER_ROOM + number].density, casters[2u * CASTER_ROOM + number].density);
    }
    return 1.0 - exp(-min(densities * caster_thickness(ray, caster, z), vec3(MAX_OPTICAL_DEPTH)) * extinction_ratio());
}

// Paints `count` entries from `first` on over the casters behind them.
void paint(View camera, uvec2 pixel, Ray ray, float farthest, uint first, uint count, inout vec3 color, inout vec3 left) {
    uint i = is_seen(left) ? count : 0u;
    while (i > 0u) {
        Caster caster;
        uint number;
        vec2 z;
        bool found = false;
        while (i > 0u && !found) {
            number = listed_number(first, --i);
            if (may_cover(i, number, pixel)) {
                caster = listed_caster(i, number);
                found = caster_seen(camera, ray, caster, farthest, z);
            }
        }
        if (found) {
            float middle = 0.5 * (z.x + z.y);
            vec3 light = light_within(camera, caster, number, pixel, middle, ray.origin + middle * ray.direction);
            vec3 opacity = opacity_of(ray, caster, number, z);
            color += left * shade_caster(caster_color_of(caster, number), light) * opacity;
            left *= 1.0 - opacity;
            i = is_seen(left) ? i : 0u;
        }
    }
}

void main() {
    uint thread = gl_LocalInvocationIndex, listed = gl_WorkGroupID.y * PART_GROUPS + gl_WorkGroupID.x;
    if (listed >= totals.parts) {
        return;
    }
    Part part = parts[paint_order(listed, totals.parts)];
    uvec2 range = ranges[part.tile];
    // If the entries cannot be divided evenly, the first parts are longer by one.
    uint each = (range.y - range.x) / part.count, longer = (range.y - range.x) % part.count;
    uint start = range.x + part.number * each + min(part.number, longer);
    uint length_left = each + uint(part.number < longer);
    View camera = pushed_camera();
    uvec2 pixel = tile_pixel(size, part.tile, thread);
    bool is_inside = all(lessThan(pixel, size));
    Ray ray = view_ray(camera, vec2(pixel) + 0.5);
    float farthest = texelFetch(distances, ivec2(min(pixel, size - 1u)), 0).r;
    vec3 color = vec3(0.0), left = vec3(is_inside ? 1.0 : 0.0);
    if (!STAGED) {
        paint(camera, pixel, ray, farthest, start, length_left, color, left);
        length_left = 0u;
    }
    while (length_left > 0u) {
        uint filled = min(length_left, TILE_PIXELS);
        length_left -= filled;
        if (thread < filled) {
            put_on_stage(thread, start + length_left + thread);
        }
        if (thread == 0u) {
            seeing = 0u;
        }
        barrier();
        paint(camera, pixel, ray, farthest, 0u, filled, color, left);
        if (is_seen(left)) {
            seeing = 1u;
        }
        barrier();
        if (seeing == 0u) {
            break;
        }
        barrier();
    }
    if (!is_inside) {
        return;
    }
    if (part.slot != NO_SLOT) {
        uint at = 2u * ((part.slot + part.number) * TILE_PIXELS + thread);
        layers[at] = color;
        layers[at + 1u] = left;
    } else {
        vec4 behind = imageLoad(colors, ivec2(pixel));
        imageStore(colors, ivec2(pixel), vec4(color + left * behind.rgb, behind.a));
    }
}
#endif
