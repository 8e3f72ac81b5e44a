out vec4 o_color;

#ifndef RIM
flat in vec4 v_irradiance;

void main() { o_color = v_irradiance; }
#else
/* Coverage of the ghost at a point, for three wavelengths at once: see lflare_footprint_coverage. */
flat in vec4 v_data[13]; /* see ghost.vert.glsl */
in vec2 v_position;

void cut_circle(vec3 ax, vec3 ay, float radius, Profile p, vec3 side)
{
    vec3 far = sqrt(ax * ax + ay * ay), inverse = -side / max(far, vec3(1e-20));
    cut(p, radius - far, ax * inverse, ay * inverse);
}

vec3 coverage(vec2 position)
{
    vec2 axis = v_data[10].xy;
    int count = int(v_data[10].z), blades = int(u_spectrum.w);
    vec3 ratio = vec3(v_data[11].w, 1.0, v_data[12].w), along = v_data[12].xyz, dx = position.x - along * axis.x, dy = position.y - along * axis.y;
    uncut();
    for (int i = 0; i < count; i++) {
        vec4 g = v_data[i], o = v_data[5 + i];
        Profile p = profile_of(g.w * ratio, vec3(o.w), i == 0 ? u_strip.w : 0.0);
        if (i == 0 && u_strip.z > 2.0) p = dark(p);
        vec3 ax = g.xyz * dx + o.xyz * axis.x, ay = g.xyz * dy + o.xyz * axis.y;
        vec3 side = mix(vec3(1.0), vec3(-1.0), lessThan(g.xyz, vec3(0.0)));
        if (i > 0 || blades == 0) {
            cut_circle(ax, ay, 1.0, p, side);
            continue;
        }
        for (int k = 0; k < blades; k++) {
            vec4 b = u_blades[k];
            if (b.w > 0.0) cut_circle(ax + b.x * b.z, ay + b.y * b.z, b.w, p, side);
            else cut(p, b.z - b.x * ax - b.y * ay, -side * b.x, -side * b.y);
        }
    }
#ifdef FRINGES
    if (u_strip.z == 0.0) return within();
    vec4 g = v_data[0], o = v_data[5];
    vec3 ax = g.xyz * dx + o.xyz * axis.x, ay = g.xyz * dy + o.xyz * axis.y;
    return within() * mask(ax, ay, profile_of(g.w * ratio, vec3(o.w), u_strip.w));
#else
    return within();
#endif
}

void main()
{
    int samples = int(v_data[10].w); /* a ghost of a few pixels: 4 x 4 */
    float grid = samples > 1 ? 0.25 * u_lens.x : 0.0;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < samples; i++) sum += coverage(v_position + grid * (vec2(i & 3, i >> 2) - 1.5));
    o_color = vec4(v_data[11].rgb * sum / v_data[10].w, 0.0);
}
#endif
