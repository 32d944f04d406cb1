#version 460
// shadows=queued, second of three passes: finds how many workgroups share the jobs, and empties the list for the next frame. Input: how
// many jobs were appended. Outputs: the number of workgroups; the empty list.
#include "shading/many_lights/queue.glsl"

layout(local_size_x = 1) in;

// Workgroups along one dimension; every device takes so many.
const uint MOST_GROUPS = 65535u;
// Jobs of a workgroup. Twin: local_size_x in shading/many_lights/queued.comp.
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
