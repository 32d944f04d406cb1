float sun_visibility(vec3 position) { return 1.0; }
