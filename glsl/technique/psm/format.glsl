// Format of the volume as a storage image, which GLSL requires. BITS: bits per channel.
#ifndef TECHNIQUE_PSM_FORMAT_GLSL
#define TECHNIQUE_PSM_FORMAT_GLSL
#if BITS == 8
#define VOLUME_FORMAT rgba8
#else
#define VOLUME_FORMAT rgba16f
#endif
#endif
