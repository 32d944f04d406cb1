// shadows=queued: jobs, a pixel and one of its lights each. Source: Pestana 2015 proposes it; the layout is ours. Twin:
// consume::many_lights::QueueData.
#ifndef CONSUME_MANY_LIGHTS_QUEUE_GLSL
#define CONSUME_MANY_LIGHTS_QUEUE_GLSL
#include "consume/many_lights/frame.glsl"

struct Queue {
    uint groups_x;  // workgroups that share the jobs
    uint groups_y;
    uint groups_z;
    uint jobs;
    uint demanded;  // places that were asked for
    uint end;       // the first of those for which there was no room, else the greatest number
};

// set 3: many_lights_queue
layout(set = 3, binding = 0, scalar) buffer Queues { Queue queue; };
layout(set = 3, binding = 1, scalar) buffer Jobs { uint jobs[]; };  // pixel · 2^light_bits + light
#endif
