/* One patch of one ghost's mesh for one light: lflare_patch_resolve on the GPU. The program PATCH draws the inside, PATCH_RIM what
   iris and rims cut. No vertices are read: gl_VertexID says which, in the order of one strip whose rows are joined by triangles
   without area. */
uniform highp sampler2D u_mesh_table; /* per ghost, mesh and knot: head, vertices */
uniform highp sampler2D u_mesh_heads; /* per ghost: head, style */
uniform highp usampler2D u_visibility;

invariant gl_Position; /* both programs put shared vertices on the same pixels */
in uvec4 a_instance; /* ghost, light, patch, band */

const int KNOTS = 12, KNOT_TEXELS = 2, VERTEX_TEXELS = 4, DIRECTIONS = 9, RINGS = 5, BANDS = 3, HEADS_ROW = 1024, MESH_ROW = 2048;
const float PIXEL_VARIANCE = 0.715 * 0.715 / 5.0;

out vec3 v_irradiance;
#ifdef PATCH_RIM
out vec4 v_iris01, v_iris2; /* see patch.frag.glsl */
out vec3 v_rim;
out vec2 v_bulge;
#endif

vec4 head(int i) { return texelFetch(u_mesh_heads, ivec2(i % HEADS_ROW, i / HEADS_ROW), 0); }
vec4 mesh(int i) { return texelFetch(u_mesh_table, ivec2(i % MESH_ROW, i / MESH_ROW), 0); }

int g_knot, g_size;         /* texel of the first of four knots; texels from one to the next */
int g_between;              /* which of them comes before the light */
float g_part;               /* how far the light is from it to the next */
int g_rings, g_directions;
float g_lamp;               /* lamp's radius times the override's scale */
vec4 g_shares;

/* Texel i of each of four knots, interpolated. */
vec4 smooth_texel(int i)
{
    i += g_knot;
    return g_shares.x * mesh(i) + g_shares.y * mesh(i + g_size) + g_shares.z * mesh(i + 2 * g_size) + g_shares.w * mesh(i + 3 * g_size);
}

vec4 straight_texel(int i)
{
    i += g_knot + g_between * g_size;
    return mix(mesh(i), mesh(i + g_size), g_part);
}

/* Irradiance next to caustics would swing on a cubic. */
vec4 lit_texel(int i)
{
    vec4 a = mesh(i + g_knot + g_between * g_size), b = mesh(i + g_knot + (g_between + 1) * g_size);
    return clamp(smooth_texel(i), 0.9 * min(a, b), 1.1 * max(a, b));
}

int vertex(int ring, int direction) { return KNOT_TEXELS + (ring * (g_directions + 1) + direction) * VERTEX_TEXELS; }

float soft(float lamp)
{
    lamp *= g_lamp;
    return sqrt(5.0 * (PIXEL_VARIANCE * u_lens.x * u_lens.x + 0.25 * lamp * lamp));
}

void main()
{
    int ghost = int(a_instance.x) * 4, light = int(a_instance.y) * 4, patch_index = int(a_instance.z);
    vec4 h0 = head(ghost), h1 = head(ghost + 1), style0 = head(ghost + 2), style1 = head(ghost + 3);
    vec4 l0 = u_lights[light], l1 = u_lights[light + 1], l2 = u_lights[light + 2];
    vec2 slope = l0.xy, axis = l0.zw;
    vec3 irradiance = l2.yzw * u_strip.y;
    int place = int(u_lights[light + 3].x);
    gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
    v_irradiance = vec3(0.0);
#ifdef PATCH_RIM
    v_iris01 = v_iris2 = vec4(1.0);
    v_rim = vec3(1.0);
    v_bulge = vec2(0.0);
#endif
    if (place < int(u_strip.x)) irradiance *= uintBitsToFloat(texelFetch(u_visibility, ivec2(place, 0), 0).r);
    g_directions = int(h0.y);
    g_rings = int(h0.z);
    int sectors = g_directions / 4, blocks = g_rings / 4, mesh_index = patch_index / (sectors * blocks), block = patch_index / sectors % blocks;
    bool ragged = (int(h1.y) >> mesh_index & 1) != 0;
#ifdef PATCH_RIM
    bool drawn = ragged || block == blocks - 1;
#else
    bool drawn = !ragged;
#endif
    if (!(l1.y < h1.x) || !drawn || !(irradiance.x + irradiance.y + irradiance.z > 0.0)) return;

    float at = (1.0 - sqrt(max(1.0 - l1.y / h1.x, 0.0))) * float(KNOTS - 1);
    int first = clamp(int(at) - 1, 0, KNOTS - 4);
    float f = at - float(first), scale = style0.w;
    g_shares = vec4(-(f - 1.0) * (f - 2.0) * (f - 3.0) / 6.0, f * (f - 2.0) * (f - 3.0) / 2.0, -f * (f - 1.0) * (f - 3.0) / 2.0, f * (f - 1.0) * (f - 2.0) / 6.0);
    g_size = int(h1.w);
    g_knot = int(h0.x) + (mesh_index * KNOTS + first) * g_size;
    g_lamp = l1.z * scale;
    g_between = int(min(f, 2.0));
    g_part = f - float(g_between);
    vec4 whole = straight_texel(0), bounds = straight_texel(1);

    /* ghosts smaller than a pixel, or than what diffraction and the lamp leave, are enlarged */
    float lamp = whole.y * l1.z, size2 = max(whole.x * whole.x, 1e-12), spread = h0.w / max(whole.z, 1e-6);
    vec3 flux = vec3(whole.w, bounds.zw);
    float even = flux.x + flux.y + flux.z > 0.0 ? clamp(2.0 - whole.x * scale / (4.0 * u_lens.x), 0.0, 1.0) : 0.0;
    vec3 flat_irradiance = flux / (3.14159265 * size2);
    float least = 2.25 * u_lens.x * u_lens.x + min(spread * spread, size2) + lamp * lamp;
    float size = scale * sqrt(max(least / size2, 1.0)), gain = scale * scale / (size * size);
    size2 *= size * size;
    float wash = PIXEL_VARIANCE * u_lens.x * u_lens.x + 0.25 * g_lamp * g_lamp * whole.y * whole.y, wash5 = max(5.0 * wash, 1e-30);
    float q = sqrt(size2 / wash5), wide = 2.0 * wash5 * (0.05 + q * (0.1875 + q * (0.25 + q * (0.125 - 0.0125 * q * q))));
    gain *= size2 / (wash5 <= size2 ? size2 + wash : wide);

    int row = gl_VertexID / 20, corner = gl_VertexID % 20, across = min(corner, 17) >> 1, along = row + (corner & 1);
    if (corner == 18) along = row + 1;
    if (corner == 19) across = 0;
    int direction = patch_index % sectors * (DIRECTIONS - 1) + across;
    float side = direction > g_directions ? -1.0 : 1.0;
    float turn = float(direction);
    if (direction > g_directions) direction = 2 * g_directions - direction;

    /* from where to where the rim reaches */
    int edge = vertex(g_rings, direction);
    vec4 edge3 = smooth_texel(edge + 3);
    float g_rate = smooth_texel(vertex(g_rings - 1, direction) + 3).w, iris_soft = soft(whole.y);
    float run = length(smooth_texel(edge).xy - smooth_texel(vertex(g_rings - 1, direction)).xy) * float(g_rings);
    float reach = 1.1 * max(iris_soft, soft(edge3.z));
    reach /= size * max(max(g_rate, 0.25 * run), 1e-9);
    float bulge = smooth_texel(vertex(0, direction) + 3).w;
    float begin = max(edge3.w - reach - 0.01, 0.0), end = 1.0 + reach + 1.2 * bulge;
    if (ragged) {
        begin = float(block) / float(blocks) * end;
        end *= float(block + 1) / float(blocks);
    }
#ifdef PATCH_RIM
    float rho = begin + (end - begin) * float(along) / float(BANDS - 1);
#else
    float rho = begin * float(block * (RINGS - 1) + along) / float(g_rings);
#endif
    rho *= float(g_rings);
    int ring = int(clamp(rho, 0.0, float(g_rings - 1))), a = vertex(ring, direction), b = vertex(ring + 1, direction);
    f = rho - float(ring);
    float g = min(f, 1.0);
    vec4 t0 = mix(smooth_texel(a), smooth_texel(b), f);
    vec3 lit_a = vec3(lit_texel(a).zw, lit_texel(a + 1).x), lit_b = vec3(lit_texel(b).zw, lit_texel(b + 1).x);
    v_irradiance = mix(max(mix(lit_a, lit_b, g), vec3(0.0)), flat_irradiance, even) * gain * irradiance * style0.rgb;
    float middle = smooth_texel(KNOT_TEXELS).x;
    vec2 local = vec2(middle + size * (t0.x - middle), size * side * t0.y);
#ifdef PATCH_RIM
    vec4 t2 = mix(smooth_texel(a + 2), smooth_texel(b + 2), f), a3 = smooth_texel(a + 3), b3 = smooth_texel(b + 3), t3 = mix(a3, b3, f);
    mat2 to_sensor = mat2(axis.x, axis.y, -axis.y * side, axis.x * side);
    v_iris01 = vec4(to_sensor * t2.xy, to_sensor * t2.zw);
    v_iris2 = vec4(to_sensor * t3.xy, soft(mix(a3.z, b3.z, g)) / u_lens.x, iris_soft / u_lens.x);
    v_rim = mix(smooth_texel(a + 1).yzw, smooth_texel(b + 1).yzw, f);
    v_bulge = vec2(turn, 4.0 * bulge);
#endif
    vec2 position = vec2(local.x * axis.x - local.y * axis.y, local.x * axis.y + local.y * axis.x);
    position += u_lens.y * (style1.x * slope + style1.y * vec2(-slope.y, slope.x));
    gl_Position = vec4(-(position - u_half.zw) / u_half.xy, 0.0, 1.0);
}
