/* One patch of one ghost's mesh for one light: lflare_patch_resolve on the GPU. The program PATCH draws the inside, or if the iris
   has a mask PATCH_RIM does, and with PATCH_STRIP what iris and rims cut. Only indices are read: gl_VertexID counts directions, then rings. */
uniform highp sampler2D u_mesh_table; /* per ghost, mesh and knot: what it says of the whole, vertices */
/* u_ghosts: per ghost head, style */
uniform highp usampler2D u_visibility;

invariant gl_Position; /* both programs put shared vertices on the same pixels */
in uvec4 a_instance; /* ghost, light, patch, band */

const int KNOT_TEXELS = 2, DIRECTIONS = 9, RINGS = 5, BANDS = 3, HEAD = 13, MESH_ROW = 2048;

centroid out vec3 v_irradiance, v_flux; /* see patch.frag.glsl */
centroid out float v_most;
out vec2 v_entrance;
#ifdef PATCH_RIM
out vec4 v_iris01, v_iris2;
out vec3 v_rim;
out vec4 v_bulge;
flat out vec4 v_light;
flat out vec2 v_spectrum;
out vec2 v_bundle;
#endif

vec4 mesh(int i) { return texelFetch(u_mesh_table, ivec2(i % MESH_ROW, i / MESH_ROW), 0); }

int g_knot, g_size;         /* texel of the first of four knots; texels from one to the next */
int g_between;              /* which of them comes before the light */
int g_rings, g_directions;
int g_texels;               /* of a vertex: 5 for three channels, 3 for one */
vec4 g_shares;

int g_mesh; /* which of many wavelengths is drawn, mixed from the meshes of three; below 0: none is */
int g_next; /* texels to the next of the three */

/* Texel i of each of four knots, interpolated. */
vec4 smooth_of(int i)
{
    i += g_knot;
    return g_shares.x * mesh(i) + g_shares.y * mesh(i + g_size) + g_shares.z * mesh(i + 2 * g_size) + g_shares.w * mesh(i + 3 * g_size);
}

/* The same, kept to what the nearest two say: weight and shrink next to caustics would swing on a cubic. */
vec4 kept_of(int i)
{
    i += g_knot;
    vec4 k0 = mesh(i), k1 = mesh(i + g_size), k2 = mesh(i + 2 * g_size), k3 = mesh(i + 3 * g_size);
    vec4 a = g_between == 0 ? k0 : g_between == 1 ? k1 : k2, b = g_between == 0 ? k1 : g_between == 1 ? k2 : k3, least = min(a, b), most = max(a, b);
    return clamp(g_shares.x * k0 + g_shares.y * k1 + g_shares.z * k2 + g_shares.w * k3, least - 0.1 * (most - least), most + 0.1 * (most - least));
}

vec4 smooth_texel(int i)
{
    if (g_mesh < 0) return smooth_of(i);
    vec3 s = place_shares(g_mesh);
    return s.x * smooth_of(i) + s.y * smooth_of(i + g_next) + s.z * smooth_of(i + 2 * g_next);
}

vec4 kept_texel(int i)
{
    if (g_mesh < 0) return kept_of(i);
    vec3 s = place_shares(g_mesh);
    return s.x * kept_of(i) + s.y * kept_of(i + g_next) + s.z * kept_of(i + 2 * g_next);
}

int vertex(int ring, int direction) { return KNOT_TEXELS + (ring * (g_directions + 1) + direction) * g_texels; }

/* What stands last in a vertex: see lflare__mesh_rates. */
float last(int ring, int direction) { return smooth_texel(vertex(ring, direction) + g_texels - 1).w; }

void main()
{
    int ghost = int(a_instance.x) * HEAD, light = int(a_instance.y) * 4, patch_index = int(a_instance.z);
    vec4 h0 = ghosts(ghost), h1 = ghosts(ghost + 1), style0 = ghosts(ghost + 2), style1 = ghosts(ghost + 3), style2 = ghosts(ghost + 4);
    vec4 l0 = u_lights[light], l1 = u_lights[light + 1], l2 = u_lights[light + 2];
    if (style2.z > 0.0) style0.rgb *= ramp(ghost + 5, int(style2.z) - 1, l1.y);
    vec2 slope = l0.xy, axis = l0.zw;
    vec3 irradiance = l2.yzw * u_strip.y * (1.0 - float(a_instance.w >> 10) / 63.0); /* see lflare_instance */
    int place = int(u_lights[light + 3].x);
    gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
    v_irradiance = v_flux = vec3(0.0);
    v_entrance = vec2(0.0);
    v_most = 0.0;
#ifdef PATCH_RIM
    v_iris01 = v_iris2 = vec4(1.0);
    v_rim = vec3(1.0);
    v_bulge = v_light = vec4(0.0);
    v_spectrum = v_bundle = vec2(0.0);
#endif
    if (place < int(u_strip.x)) irradiance *= uintBitsToFloat(texelFetch(u_visibility, ivec2(place, 0), 0).r);
    g_directions = int(h0.y);
    g_rings = int(h0.z);
    int sectors = g_directions / 4, blocks = g_rings / 4, mesh_index = patch_index / (sectors * blocks), block = patch_index / sectors % blocks;
    bool split_mesh = h1.z > 1.0, mixed = split_mesh && u_bands.x > 0.0, ragged = (int(h1.y) >> (mixed ? 0 : mesh_index) & 1) != 0;
#ifdef PATCH_STRIP
    bool drawn = ragged || block == blocks - 1;
#else
    bool drawn = !ragged;
#endif
    if (!(l1.y < h1.x) || !drawn || !(irradiance.x + irradiance.y + irradiance.z > 0.0)) return;

    int knots = (int(h1.y) & 8) != 0 ? 23 : 12;
    float at = (1.0 - sqrt(max(1.0 - l1.y / h1.x, 0.0))) * float(knots - 1);
    int first = clamp(int(at) - 1, 0, knots - 4);
    float f = at - float(first), scale = style0.w;
    g_shares = vec4(-(f - 1.0) * (f - 2.0) * (f - 3.0) / 6.0, f * (f - 2.0) * (f - 3.0) / 2.0, -f * (f - 1.0) * (f - 3.0) / 2.0, f * (f - 1.0) * (f - 2.0) / 6.0);
    g_size = int(h1.w);
    g_next = knots * g_size;
    g_mesh = mixed ? mesh_index : -1;
    g_knot = int(h0.x) + ((mixed ? 0 : mesh_index) * knots + first) * g_size;
    g_texels = split_mesh ? 3 : 5;
    g_lamp = l1.z * scale;
    g_between = int(min(f, 2.0));
    int whole_at = g_knot + g_between * g_size + (mixed ? g_next : 0);
    vec4 whole = mix(mesh(whole_at), mesh(whole_at + g_size), f - float(g_between)), bounds = mix(mesh(whole_at + 1), mesh(whole_at + 1 + g_size), f - float(g_between));

    /* ghosts smaller than a pixel, or than what diffraction and the lamp leave, grow: see lflare__patch_grow */
    vec3 growth = grow(whole.x, max(whole.z, 1e-6), whole.y, h0.w, bounds.z < 0.0 ? -scale : scale, l1.z);
    float grown = growth.x, even = growth.y, gain = growth.z;

    int row = gl_VertexID / DIRECTIONS, direction = patch_index % sectors * (DIRECTIONS - 1) + gl_VertexID % DIRECTIONS;
    float side = direction > g_directions ? -1.0 : 1.0, turn = float(direction);
    if (direction > g_directions) direction = 2 * g_directions - direction;

    /* from where to where the rim reaches, in rings */
    vec4 edge = smooth_texel(vertex(g_rings, direction) + (split_mesh ? 1 : 4));
    float edge_lamp = split_mesh ? edge.w : edge.z, edge_shrink = split_mesh ? kept_texel(vertex(g_rings, direction) + 1).y : kept_texel(vertex(g_rings, direction) + 1).w;
    float iris_soft = soft(whole.y), bulge = last(0, direction), widest = sqrt(u_spectrum.x / u_spectrum.y);
    float inverse = 1.1 / max(scale * last(g_rings - 1, direction) + abs(grown) * whole.z, 1.5 * u_lens.x);
    vec2 reach = edges(vec4(iris_soft, soft(edge_lamp), widest * fringe(edge_shrink, whole.y, scale), widest * fringe(edge_shrink, edge_lamp, scale)) * inverse); /* see lflare__patch_band */
    float begin = float(g_rings) * max((split_mesh ? last(g_rings, direction) : edge.w) - reach.x - u_strip.w - 0.01, 0.0);
    float end = float(g_rings) * (1.0 + reach.y + u_strip.w + 1.2 * bulge);
    if (ragged) {
        begin = float(block) / float(blocks) * end;
        end *= float(block + 1) / float(blocks);
    }
#ifdef PATCH_STRIP
    at = begin + (end - begin) * float(row) / float(BANDS - 1);
#else
    at = min(float(block * (RINGS - 1) + row), begin);
#endif
    int ring = int(clamp(at, 0.0, float(g_rings - 1))), a = vertex(ring, direction);
    f = at - float(ring);
    vec4 t0 = smooth_texel(a), t1 = kept_texel(a + 1);
    float spread_of_shrink = split_mesh ? t1.z : kept_texel(a + 2).w;
#ifdef PATCH_RIM
    vec4 t2 = smooth_texel(a + 2), t3 = vec4(0.0), t4 = vec4(0.0);
    if (!split_mesh) t3 = smooth_texel(a + 3), t4 = smooth_texel(a + 4);
#endif
    if (f > 0.0) { /* between two rings, or beyond the last */
        float g = min(f, 1.0);
        int b = vertex(ring + 1, direction);
        t0 = mix(t0, smooth_texel(b), f);
        t1 = mix(t1, kept_texel(b + 1), g);
        spread_of_shrink = split_mesh ? t1.z : mix(spread_of_shrink, kept_texel(b + 2).w, g);
#ifdef PATCH_RIM
        t2 = mix(t2, smooth_texel(b + 2), f);
        if (!split_mesh) {
            t3 = mix(t3, smooth_texel(b + 3), f);
            vec4 b4 = smooth_texel(b + 4);
            t4 = vec4(mix(t4.xy, b4.xy, f), mix(t4.z, b4.z, g), 0.0);
        }
#endif
    }
    spread_of_shrink = max(spread_of_shrink, 1e-20);
    int mesh_or_all = split_mesh ? mesh_index : -1;
    vec2 spectrum = u_bands.x > 0.0 ? spectrum_of(int(a_instance.x), l1.y, h1.x) : vec2(0.0), bundle = u_bands.x > 0.0 ? bundle_of(spectrum, t0.zw) : vec2(0.0);
    vec3 weight = channels(spectrum, bundle, mesh_or_all, max(split_mesh ? t1.xxx : t1.xyz, vec3(0.0))) * gain, light_colour = irradiance * style0.rgb;
#ifndef PATCH_RIM
    weight *= summed(spectrum, bundle, mesh_or_all) * light_colour;
#endif
    float shrink = abs(split_mesh ? t1.y : t1.w), flat_share = max(even, clamp(2.0 - shrink / spread_of_shrink, 0.0, 1.0));
    v_irradiance = (1.0 - flat_share) * weight / max(shrink, spread_of_shrink);
    v_flux = flat_share * weight * scale * scale;
    vec4 centre = smooth_texel(KNOT_TEXELS);
    vec2 in_at = vec2(t0.z - centre.z, side * t0.w);
    vec2 local = vec2(centre.x + scale * (t0.x - centre.x), scale * side * t0.y) + grown * in_at;
    v_entrance = vec2(in_at.x * axis.x - in_at.y * axis.y, in_at.x * axis.y + in_at.y * axis.x);
    v_most = 8.0 / (spread_of_shrink * scale * scale);
#ifdef PATCH_RIM
    v_light = vec4(light_colour, split_mesh ? 0.0 : u_bands.x);
    v_spectrum = spectrum;
    v_bundle = bundle;
    float apart = 0.0; /* way to the next wavelength's picture, pixels */
    if (mixed) {
        vec3 d = 0.5 * (place_shares(min(mesh_index + 1, int(u_bands.x) - 1)) - place_shares(max(mesh_index - 1, 0)));
        int v = vertex(int(clamp(at, 0.0, float(g_rings))), direction);
        apart = 0.715 * scale * length(d.x * smooth_of(v).xy + d.y * smooth_of(v + g_next).xy + d.z * smooth_of(v + 2 * g_next).xy) / u_lens.x;
    }
    mat2 to_sensor = mat2(axis.x, axis.y, -axis.y * side, axis.x * side);
    if (split_mesh) {
        vec2 iris = to_sensor * t2.yz;
        v_iris01 = vec4(iris, iris);
        v_iris2 = vec4(iris, length(vec2(soft(t1.w) / u_lens.x, apart)), length(vec2(iris_soft / u_lens.x, apart)));
        v_rim = vec3(t2.x);
    } else {
        v_iris01 = vec4(to_sensor * t3.xy, to_sensor * t3.zw);
        v_iris2 = vec4(to_sensor * t4.xy, soft(t4.z) / u_lens.x, iris_soft / u_lens.x);
        v_rim = t2.xyz;
    }
    float real_shrink = split_mesh ? t1.y : t1.w;
    v_bulge = vec4(turn, 4.0 * bulge, vec2(fringe(real_shrink, whole.y, scale), fringe(real_shrink, split_mesh ? t1.w : t4.z, scale)) / u_lens.x);
#endif
    vec2 position = vec2(local.x * axis.x - local.y * axis.y, local.x * axis.y + local.y * axis.x);
    position += u_lens.y * (style1.x * slope + style1.y * vec2(-slope.y, slope.x)) + style2.xy;
    gl_Position = vec4(-(position - u_half.zw) / u_half.xy, 0.0, 1.0);
}
