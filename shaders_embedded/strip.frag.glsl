/* How much of a light's disc the depth buffer leaves open, faded in time: one fragment a light. The strip holds the bits of a
   float in an integer texel, which every GL 3.3, ES 3.0 and WebGL 2 can draw to. */
layout(std140) uniform lflare_strip {
    vec4 u_clip[3];   /* the projection's rows x, y and w, such that w is the distance ahead; first.w: lights that have a past */
    vec4 u_region;    /* the view in the depth texture, texels: x, y, width, height; 0 = all of it */
    vec4 u_fade;      /* share of the way up; down; 1 where depth grows with distance, else -1; taps, a multiple of 4 */
    vec4 u_disc[232]; /* direction / -z: x, y; tangent of the radius, < 0: not in front of the camera; depth that begins to hide */
};
uniform highp sampler2D u_depth;
uniform highp usampler2D u_before;

out highp uint o_visibility;

/* Taps along a spiral of equal areas. Its turn was searched for at 256 taps: an edge anywhere across the disc then gives a
   share at most 0.017 wrong (the golden angle: 0.020). */
const float TURN = 2.3075, START = 0.55;

float disc_open(vec4 disc)
{
    vec2 whole = vec2(textureSize(u_depth, 0)), size = u_region.z > 0.0 ? u_region.zw : whole;
    vec2 last = min(u_region.xy + size, whole) - 1.0, from = min(u_region.xy, last);
    vec3 middle = normalize(vec3(disc.xy, -1.0)), across = normalize(cross(middle, vec3(0.0, 1.0, 0.0))), up = cross(across, middle);
    float radius = max(disc.z, 2.0 / (size.y * length(u_clip[1].xy))), open = 0.0;
    mat3 turned = mat3(across, up, middle), place = transpose(mat3(u_clip[0].xyz, u_clip[1].xyz, u_clip[2].xyz)) * turned;
    for (float i = START; i < u_fade.w; i += 4.0) { /* four at a time: their fetches need not wait for each other */
        vec4 at = vec4(i, i + 1.0, i + 2.0, i + 3.0), far = radius * sqrt(at / u_fade.w), depth;
        vec4 x = far * cos(TURN * at), y = far * sin(TURN * at);
        for (int k = 0; k < 4; k++) {
            vec3 clip = place * vec3(x[k], y[k], 1.0);
            vec2 texel = u_region.xy + size * (0.5 + 0.5 * clip.xy / max(clip.z, 1e-3));
            depth[k] = texelFetch(u_depth, ivec2(clamp(texel, from, last)), 0).r;
        }
        open += dot(step(0.0, (depth - disc.w) * u_fade.z), vec4(1.0));
    }
    return open / u_fade.w;
}

void main()
{
    int light = int(gl_FragCoord.x);
    float before = uintBitsToFloat(texelFetch(u_before, ivec2(light, 0), 0).r), now = 0.0;
    vec4 disc = u_disc[light];
    if (disc.z >= 0.0) now = disc_open(disc);
    float faded = before + (now - before) * (now > before ? u_fade.x : u_fade.y);
    if (light >= int(u_clip[0].w) || abs(now - faded) < 1e-5) faded = now;
    o_visibility = floatBitsToUint(faded);
}
