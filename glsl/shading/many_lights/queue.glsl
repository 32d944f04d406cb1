// shadows=queued: the list of jobs; a job is a pixel and one of its lights. Source: Pestana 2015 proposes it; the layout is ours.
// Twin: shading::many_lights::QueueData.
#ifndef CONSUME_MANY_LIGHTS_QUEUE_GLSL
#define CONSUME_MANY_LIGHTS_QUEUE_GLSL
#include "shading/many_lights/frame.glsl"

struct Queue {
    uint groups_x;  // workgroups that share the jobs
    uint groups_y;
    uint groups_z;
    uint jobs;
    uint demanded;  // number of entries requested, including those that do not fit
    uint end;       // index of the first entry that does not fit; 0xffffffff if all fit
};

// set 3: many_lights_queue
layout(set = 3, binding = 0, scalar) buffer Queues { Queue queue; };
layout(set = 3, binding = 1, scalar) buffer Jobs { uint jobs[]; };  // pixel · 2^light_bits + light
#endif
