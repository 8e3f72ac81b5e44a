/* What one frame hands to every stage: lflare__gl_frame in lensflare.h has the same layout. */
layout(std140) uniform lflare_frame {
    vec4 u_half;       /* half width, half height of the frame on the sensor; sensor point at its middle */
    vec4 u_lens;       /* mm per pixel, EFL, entrance radius, iris radius */
    vec4 u_spectrum;   /* wavelengths in mm; number of blades */
    vec4 u_strip;      /* lights in the visibility strip, 0 = none counts; gain; the iris has a mask; its softness */
    vec4 u_burst[3];   /* starburst: gain, mm of its unit; tail, half thickness of the streak; gain of that, 0 */
    vec4 u_blades[16]; /* normal, distance, arc radius */
    vec4 u_lights[960];/* 240 x (slope, axis)(slope length, field angle, angular radius, image x)(image y, irradiance)(place in the strip, -, reach of starburst, of streak) */
};
