// Macro with which technique/avsm/raster_order.frag and technique/avsm/unpack.comp repeat declarations for each of the ATTACHMENTS color
// attachments that hold the curves. Attachment i stores nodes 2i and 2i + 1 as (depth, value, depth, value). ATTACHMENTS is NODES / 2.
// Input attachments and outputs are separate variables, since a portable shader cannot index either in a loop.
#ifndef TECHNIQUE_AVSM_ATTACHMENTS_GLSL
#define TECHNIQUE_AVSM_ATTACHMENTS_GLSL

#if ATTACHMENTS == 2
#define EACH_ATTACHMENT(DO) DO(0) DO(1)
#elif ATTACHMENTS == 4
#define EACH_ATTACHMENT(DO) DO(0) DO(1) DO(2) DO(3)
#elif ATTACHMENTS == 8
#define EACH_ATTACHMENT(DO) DO(0) DO(1) DO(2) DO(3) DO(4) DO(5) DO(6) DO(7)
#endif
#endif
