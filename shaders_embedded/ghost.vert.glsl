/* One ghost of one light: lflare_footprint_resolve on the GPU, then geometry drawn tightly around it. The program RIM draws
   a ring of 16 corners that holds the soft edges; the program INSIDE what the ring leaves, where nothing is cut and a
   fragment is one constant. No vertices are read: gl_VertexID says which, in the order of a strip
   for the ring and of a fan for the inside, whose straight sides would leave slivers in a strip. */
uniform highp sampler2D u_lens_table;     /* per ghost: head, rims */
uniform highp sampler2D u_settings_table; /* per ghost: field samples, style */
uniform highp usampler2D u_visibility;    /* one texel a light, the bits of a float */

invariant gl_Position; /* both programs put shared corners on the same pixels */
in uvec4 a_instance; /* ghost, light, patch, band */

const int CORNERS = 16, EDGES = 5, RIMS = 12, SAMPLES = 64;
const int LENS_TEXELS = 4 + 3 * RIMS, SETTINGS_TEXELS = 2 * SAMPLES + 11, ROW = 1024;
const float PI = 3.14159265, PIXEL_VARIANCE = 0.715 * 0.715 / 5.0;

#ifdef RIM
/* 0-4: gain of each edge at three wavelengths, soft at the middle one; 5-9: offset, fringes' length; 10: axis, edge count, samples a
   pixel; 11: irradiance, softness at the first wavelength over that at the middle one; 12: centres on the axis, the same at the third */
flat out vec4 v_data[13];
out vec2 v_position;           /* on the sensor, less the override's shift */
#else
flat out vec4 v_irradiance;
#endif

vec4 lens_texel(int i) { return texelFetch(u_lens_table, ivec2(i % ROW, i / ROW), 0); }
vec4 settings_texel(int i) { return texelFetch(u_settings_table, ivec2(i % ROW, i / ROW), 0); }

/* lflare__style_tint: what a ramp of `left` + 1 stops, the first at texel `at`, does to the tint at a field angle */
vec3 ramp(int at, int left, float angle)
{
    vec4 a = settings_texel(at), b = left > 0 ? settings_texel(at + 1) : a;
    for (; left > 1 && angle > b.w; left--) {
        at++;
        a = b;
        b = settings_texel(at + 1);
    }
    return mix(a.rgb, b.rgb, left > 0 ? clamp((angle - a.w) / (b.w - a.w), 0.0, 1.0) : 0.0);
}

struct Edge {
    vec3 gain, offset, inner, outer;
    float soft, ring; /* before the iris's softness */
};

vec3 g_drawn, g_m11, g_m12, g_ratio;
float g_centroid, g_slope, g_lamp, g_pixel, g_fringes;

Edge edge_of(vec3 a, vec3 b, float radius, float softness)
{
    Edge e;
    a /= radius;
    b /= radius;
    e.gain = a / g_drawn;
    e.offset = a * g_centroid + b * g_slope;
    float c = g_m12.y * a.y - g_m11.y * b.y, lamp = c / g_drawn.y * g_lamp, grid = g_pixel * e.gain.y;
    e.soft = sqrt(5.0 * (PIXEL_VARIANCE * grid * grid + 0.25 * lamp * lamp));
    e.ring = g_fringes * sqrt(0.5 * u_spectrum.y * abs(a.y * c) / max(abs(g_m11.y), 1e-12));
    Profile p = profile_of(e.soft * g_ratio, vec3(e.ring), softness);
    e.inner = p.inner;
    e.outer = p.outer;
    return e;
}

Edge g_edges[EDGES];
int g_count;

/* Along direction d from the middle wavelength's centre: the first edge met, as a tangent line normal.p <= x that leaves all
   wavelengths inside; p from the shift. */
vec3 tangent(vec2 d, vec2 axis, vec3 along)
{
    float best = 3e37;
    vec2 normal = d;
    vec3 reach = vec3(0.0);
    int blades = int(u_spectrum.w);
    for (int i = 0; i < g_count; i++) {
        Edge e = g_edges[i];
        float side = e.gain.y < 0.0 ? -1.0 : 1.0;
        vec3 gain = max(abs(e.gain), vec3(1e-12));
        int parts = i == 0 && blades > 0 ? blades : 1;
        for (int k = 0; k < parts; k++) {
            vec4 blade = i == 0 && blades > 0 ? u_blades[k] : vec4(0.0);
            vec2 offset = e.offset.y * axis;
            float t;
            vec2 n;
            vec3 far;
            if (i > 0 || blades == 0 || blade.w > 0.0) {
                float arc = blade.w > 0.0 ? blade.w : 1.0, radius = arc + e.outer.y;
                offset += blade.xy * blade.z;
                float b = dot(offset, d) * side;
                t = (sqrt(max(radius * radius - dot(offset, offset) + b * b, 0.0)) - b) / gain.y;
                n = (gain.y * t * d + side * offset) / radius;
                n /= max(length(n), 1e-6);
                far = (vec3(arc) + e.outer - side * (e.offset * dot(axis, n) + vec3(dot(blade.xy, n) * blade.z))) / gain;
            } else {
                float facing = dot(blade.xy, d) * side;
                float room = blade.z + e.outer.y - dot(blade.xy, offset);
                t = facing > 1e-6 ? max(room, 0.0) / (gain.y * facing) : 3e38;
                n = side * blade.xy;
                far = (vec3(blade.z) + e.outer - e.offset * dot(axis, blade.xy)) / gain;
            }
            if (t < best) {
                best = t;
                normal = n;
                reach = far;
            }
        }
    }
    reach += along * dot(axis, normal);
    return vec3(normal, max(reach.x, max(reach.y, reach.z)));
}

/* Along direction d from the middle wavelength's centre: how far nothing is cut at any wavelength. */
float uncut(vec2 d, vec2 axis, vec3 along)
{
    float best = 3e37;
    int blades = int(u_spectrum.w);
    for (int i = 0; i < g_count; i++) {
        Edge e = g_edges[i];
        vec3 side = mix(vec3(1.0), vec3(-1.0), lessThan(e.gain, vec3(0.0))), gain = max(abs(e.gain), vec3(1e-12));
        vec3 start = e.offset + e.gain * (vec3(along.y) - along);
        int parts = i == 0 && blades > 0 ? blades : 1;
        for (int k = 0; k < parts; k++) {
            vec4 blade = i == 0 && blades > 0 ? u_blades[k] : vec4(0.0);
            vec3 t;
            if (i > 0 || blades == 0 || blade.w > 0.0) {
                vec3 radius = vec3(blade.w > 0.0 ? blade.w : 1.0) - e.inner;
                vec3 ox = start * axis.x + vec3(blade.x * blade.z), oy = start * axis.y + vec3(blade.y * blade.z);
                vec3 b = (ox * d.x + oy * d.y) * side, c = radius * radius - ox * ox - oy * oy;
                t = (sqrt(max(c + b * b, vec3(0.0))) - b) / gain;
                if (min(radius.x, min(radius.y, radius.z)) <= 0.0 || min(c.x, min(c.y, c.z)) <= 0.0) t = vec3(0.0);
            } else {
                vec3 facing = dot(blade.xy, d) * side, room = vec3(blade.z) - e.inner - start * dot(blade.xy, axis);
                t = mix(vec3(3e37), room / max(gain * facing, vec3(1e-12)), greaterThan(facing, vec3(1e-6)));
                t = mix(t, vec3(0.0), lessThan(room, vec3(0.0)));
            }
            best = min(best, min(t.x, min(t.y, t.z)));
        }
    }
    return max(best, 0.0);
}

void main()
{
    int ghost = int(a_instance.x), light = int(a_instance.y), i;
    vec4 l0 = u_lights[light * 4], l1 = u_lights[light * 4 + 1], l2 = u_lights[light * 4 + 2];
    vec2 slope = l0.xy, axis = l0.zw;
    vec3 irradiance = l2.yzw * u_strip.y * (1.0 - float(a_instance.w >> 10) / 63.0); /* see lflare_instance */
    int place = int(u_lights[light * 4 + 3].x);
    int lens = ghost * LENS_TEXELS, settings = ghost * SETTINGS_TEXELS;
    vec4 h0 = lens_texel(lens), h1 = lens_texel(lens + 1), h2 = lens_texel(lens + 2);
    vec4 style0 = settings_texel(settings + 2 * SAMPLES), style1 = settings_texel(settings + 2 * SAMPLES + 1), style2 = settings_texel(settings + 2 * SAMPLES + 2);
    if (style2.z > 0.0) style0.rgb *= ramp(settings + 2 * SAMPLES + 3, int(style2.z) - 1, l1.y);
    gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
    if (place < int(u_strip.x)) irradiance *= uintBitsToFloat(texelFetch(u_visibility, ivec2(place, 0), 0).r);

    /* the field row at the light's angle */
    float at = l1.y * style1.w * float(SAMPLES - 1);
    int j = int(min(at, float(SAMPLES - 2)));
    vec4 a1 = settings_texel(settings + 2 * j + 1), b1 = settings_texel(settings + 2 * j + 3), s1 = mix(a1, b1, at - float(j));
    float middle_x = mix(settings_texel(settings + 2 * j).w, settings_texel(settings + 2 * j + 2).w, at - float(j));
    int c = clamp(j, 1, SAMPLES - 3); /* colours turn faster than shapes: a cubic */
    float f = at - float(c);
    vec3 p0 = settings_texel(settings + 2 * c - 2).rgb, p1 = settings_texel(settings + 2 * c).rgb;
    vec3 p2 = settings_texel(settings + 2 * c + 2).rgb, p3 = settings_texel(settings + 2 * c + 4).rgb;
    vec3 weight = p1 + f * (p2 - p0 / 3.0 - p1 / 2.0 - p3 / 6.0 + f * (p0 / 2.0 - p1 + p2 / 2.0 + f * ((p1 - p2) / 2.0 + (p3 - p0) / 6.0)));
    int binding = int(a1.w); /* EDGES - 1 at most */
    float radius = max(s1.x, 1e-6 * u_lens.z), scale = style0.w;

    /* least size: P 3 */
    vec3 ma11 = vec3(h0.x, h1.x, h2.x), ma12 = vec3(h0.y, h1.y, h2.y);
    g_m11 = vec3(h0.z, h1.z, h2.z);
    g_m12 = vec3(h0.w, h1.w, h2.w);
    vec3 spread = 0.61 * u_spectrum.xyz * g_m12 / radius, lamp = l1.z * g_m12;
    vec3 size = max(abs(g_m11), sqrt(vec3(u_lens.x * u_lens.x) + spread * spread + lamp * lamp) / radius);
    g_drawn = mix(size, -size, lessThan(g_m11, vec3(0.0))) * scale;
    g_ratio = abs(vec3(g_drawn.y) / g_drawn);
    vec3 bright = max(weight, vec3(0.0)) * style0.rgb / (size * size);
    g_fringes = u_burst[2].w >= 0.0 && max(bright.x, max(bright.y, bright.z)) >= u_burst[2].w ? 1.0 : 0.0;
    g_centroid = middle_x;
    g_slope = l1.x;
    g_lamp = l1.z * scale;
    g_pixel = u_lens.x;
    bool fine = radius * abs(g_drawn.y) < 4.0 * g_pixel;
    if (fine) g_pixel *= 0.25;

    /* edges: the iris, then those that cut into the smallest at any wavelength */
    Edge found[EDGES];
    int count = 1;
    found[0] = edge_of(ma11, ma12, u_lens.w, u_strip.w);
    if ((binding & 1) != 0) found[count++] = edge_of(vec3(1.0), vec3(0.0), u_lens.z, 0.0);
    for (i = 0; i < RIMS; i++)
        if ((binding >> (i + 1) & 1) != 0) {
            vec4 r0 = lens_texel(lens + 4 + i * 3), r1 = lens_texel(lens + 5 + i * 3), r2 = lens_texel(lens + 6 + i * 3);
            found[count++] = edge_of(vec3(r0.x, r1.x, r2.x), vec3(r0.y, r1.y, r2.y), r0.z > 0.0 ? r0.z : u_lens.w, r0.z > 0.0 ? 0.0 : u_strip.w); /* 0: the iris */
        }
    int smallest = 0;
    float reach = 3e38;
    for (i = 0; i < count; i++) {
        float extent = (1.0 + found[i].outer.y) / max(abs(found[i].gain.y), 1e-12);
        if (extent < reach) { reach = extent; smallest = i; }
    }
    Edge least = found[smallest];
    vec3 middle = -least.offset / least.gain, far = (vec3(1.0) + least.outer) / max(abs(least.gain), vec3(1e-12));
    g_edges[0] = found[0];
    g_count = 1;
    for (i = 1; i < count; i++) {
        Edge e = found[i];
        vec3 over = abs(e.gain * middle + e.offset) + abs(e.gain) * far - 1.0 + e.soft * g_ratio;
        if (i == smallest || max(over.x, max(over.y, over.z)) > 0.0) g_edges[g_count++] = e;
    }

    /* irradiance over the area really drawn: lflare__soft_size2 */
    vec3 size2 = radius * radius * g_drawn * g_drawn;
    float wash = (PIXEL_VARIANCE * g_pixel * g_pixel * s1.y + 0.25 * g_lamp * g_lamp * s1.z) / PI, wash5 = max(5.0 * wash, 1e-30);
    vec3 q = sqrt(size2 / wash5), wide = 2.0 * wash5 * (0.05 + q * (0.1875 + q * (0.25 + q * (0.125 - 0.0125 * q * q))));
    irradiance *= max(weight, vec3(0.0)) * style0.rgb / (size * size) * size2 / mix(wide, size2 + wash, lessThanEqual(vec3(wash5), size2));
    vec3 along = g_m11 * g_centroid + g_m12 * g_slope;
#ifdef RIM
    for (i = 0; i < EDGES; i++) {
        Edge e = g_edges[i < g_count ? i : 0];
        v_data[i] = vec4(e.gain, e.soft);
        v_data[5 + i] = vec4(e.offset, e.ring);
    }
    v_data[10] = vec4(axis, float(g_count), fine ? 16.0 : 1.0);
    v_data[11] = vec4(irradiance, g_ratio.x);
    v_data[12] = vec4(along, g_ratio.z);
    v_position = vec2(0.0);
#else
    v_irradiance = vec4(irradiance, 0.0);
#endif
    if (at >= float(SAMPLES - 1) || !(irradiance.x + irradiance.y + irradiance.z > 0.0)) return;

    /* the corner between two neighbouring tangents, or the point below it where the soft edge ends */
#ifdef RIM
    int corner = gl_VertexID >> 1;
    bool low = (gl_VertexID & 1) != 0;
#else
    int corner = gl_VertexID; /* the first stands for the centre */
    bool low = true;
#endif
    float turn = 2.0 * PI / float(CORNERS), angle = (float(corner % CORNERS) + 0.37) * turn;
    vec2 centre = along.y * axis, between = vec2(cos(angle + 0.5 * turn), sin(angle + 0.5 * turn)), position;
    vec3 p = tangent(vec2(cos(angle), sin(angle)), axis, along);
    vec3 next = tangent(vec2(cos(angle + turn), sin(angle + turn)), axis, along);
    float bend = p.x * next.y - p.y * next.x;
    if (bend > 1e-3) position = vec2(p.z * next.y - next.z * p.y, p.x * next.z - next.x * p.z) / bend;
    else position = centre + between * max(p.z - dot(p.xy, centre), 0.0) / max(dot(p.xy, between), 0.05); /* one straight edge twice */
    if (low) {
        vec2 way = position - centre;
        float far = max(length(way), 1e-20);
        position = centre + way * (fine || u_strip.z > 0.0 ? 0.0 : min(uncut(way / far, axis, along) / far, 1.0));
    }
#ifndef RIM
    if (gl_VertexID == 0) position = centre;
#else
    v_position = position;
#endif
    vec2 shift = u_lens.y * (style1.x * slope + style1.y * vec2(-slope.y, slope.x)) + style2.xy;
    gl_Position = vec4(-(position + shift - u_half.zw) / u_half.xy, 0.0, 1.0); /* the picture is the sensor turned round */
}
