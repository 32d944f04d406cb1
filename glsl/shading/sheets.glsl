// Sheets in shaders of pictures: read from the picture's triangles, unless the technique's look-up has its own.
#ifndef CONSUME_SHEETS_GLSL
#define CONSUME_SHEETS_GLSL
#ifndef ALPHA_TRIANGLES
#define ALPHA_TRIANGLES triangles
#endif
#include "world/sheet.glsl"
#endif
