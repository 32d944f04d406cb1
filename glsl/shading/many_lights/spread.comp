#version 460
// shadows=queued, second of three passes: computes how many workgroups share the jobs, and empties the list for the next frame. Input: the
// number of appended jobs. Outputs: the number of workgroups; the empty list.
#include "shading/many_lights/queue.glsl"

layout(local_size_x = 1) in;

// Largest number of workgroups along one dimension that every device supports.
const uint MOST_GROUPS = 65535u;
// Number of jobs per workgroup, one per thread. Twin: local_size_x in shading/many_lights/queued.comp.
const uint SHARE = 64u;

void main() {
    queue.jobs = min(queue.demanded, queue.end);
    uint groups = (queue.jobs + SHARE - 1u) / SHARE;
    queue.groups_x = min(groups, MOST_GROUPS);
    queue.groups_y = (groups + MOST_GROUPS - 1u) / MOST_GROUPS;
    queue.groups_z = 1u;
    queue.demanded = 0u;
    queue.end = 0xffffffffu;
}
