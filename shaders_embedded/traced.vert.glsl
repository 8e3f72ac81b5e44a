/* One patch of one traced ghost for one light: lflare__traced_resolve on the GPU (H 4). Programs as for patch.vert.glsl; see there, too,
   for what vertices are called. */
uniform highp sampler2D u_traced_lens;   /* surfaces, stop, z of the sensor; per surface: surface, its terms, index, film */
uniform highp sampler2D u_traced_ghosts; /* per ghost: surface pair, style, outlines */
uniform highp usampler2D u_visibility;

invariant gl_Position; /* both programs put shared vertices on the same pixels */
in uvec4 a_instance; /* ghost, light, patch, band */

const int DIRECTIONS = 9, RINGS = 5, BANDS = 3, ROW = 1024, SURFACE = 132, GHOST = 729, OUTLINE = 242, KNOTS = 12, KNOT = 20, SIDES = 17;
const float PIXEL_VARIANCE = 0.715 * 0.715 / 5.0, PI = 3.14159265;

centroid out vec3 v_irradiance, v_flux; /* see patch.frag.glsl */
centroid out float v_most;
out vec2 v_entrance;
#ifdef PATCH_RIM
out vec4 v_iris01, v_iris2;
out vec3 v_rim;
out vec4 v_bulge;
#endif

vec4 lens(int i) { return texelFetch(u_traced_lens, ivec2(i % ROW, i / ROW), 0); }
vec4 ghosts(int i) { return texelFetch(u_traced_ghosts, ivec2(i % ROW, i / ROW), 0); }

int g_surfaces, g_stop, g_channel;
ivec2 g_pair;
float g_sensor_z, g_slope;

struct Ray {
    vec3 p, d;
    vec2 stop, sensor;
    float relative;
    vec3 weight;
    bool arrives;
};

float term(vec4 a, vec4 b, int j) { return j < 4 ? a[j] : b[j - 4]; }

/* lflare__traced_meet */
bool meet(vec4 s, vec4 a, vec4 b, float way, inout Ray r, out vec3 normal)
{
    float c = s.y, k = s.w;
    bool polynomial = a != vec4(0.0) || b != vec4(0.0);
    normal = vec3(0.0);
    r.p = vec3(r.p.xy - r.p.z / r.d.z * r.d.xy, 0.0);
    float u = c * (dot(r.d.xy, r.d.xy) + k * r.d.z * r.d.z), v = c * dot(r.p.xy, r.d.xy) - r.d.z, e = c * dot(r.p.xy, r.p.xy), root = v * v - u * e;
    if (root < 0.0 && !polynomial) return false;
    r.p += (root >= 0.0 ? e / (-v + way * sqrt(root)) : 0.0) * r.d;
    normal = vec3(c, c, c * k * r.p.z - 1.0);
    for (int pass = 0; pass < 6 && polynomial; pass++) {
        float r2 = dot(r.p.xy, r.p.xy), inverse = 1.0 / (s.z * s.z), bent = 1.0 - k * c * c * r2, conic = sqrt(max(bent, 1e-6)), x = r2 * inverse, sag = 0.0, slope = 0.0;
        for (int j = 7; j >= 0; j--) {
            slope = slope * x + sag;
            sag = sag * x + term(a, b, j);
        }
        slope = slope * x + sag;
        sag = sag * x + c * r2 / (1.0 + conic);
        normal = vec3(vec2(c / conic + 2.0 * slope * inverse), -1.0);
        if (bent < 0.0) return false;
        r.p += (sag - r.p.z) / (r.d.z - normal.x * dot(r.p.xy, r.d.xy)) * r.d;
    }
    if (!(normal.z < 0.0)) return false; /* past the equator: the other sheet */
    normal = normalize(vec3(normal.xy * r.p.xy, normal.z));
    return true;
}

/* lflare__traced_pass */
bool go_on(int film, float before, float after, bool reflected, vec3 normal, bool weigh, inout Ray r)
{
    float along = dot(r.d, normal), cosine = abs(along), eta = before / after, beyond = 1.0 - eta * eta * (1.0 - cosine * cosine);
    if (weigh) {
        float at = 127.0 * (before > after ? sqrt(max(beyond, 0.0)) : cosine);
        int i = int(clamp(at, 0.0, 126.0));
        vec3 share = mix(lens(film + i).rgb, lens(film + i + 1).rgb, at - float(i));
        r.weight *= reflected ? share : vec3(1.0) - share;
    }
    if (reflected) {
        r.d -= 2.0 * along * normal;
        return true;
    }
    if (beyond < 0.0) return false;
    r.d = eta * r.d + ((along < 0.0 ? -sqrt(beyond) : sqrt(beyond)) - eta * along) * normal;
    return true;
}

/* lflare__traced_ray_make */
Ray trace(vec2 entrance, bool weigh)
{
    float norm = inversesqrt(1.0 + g_slope * g_slope), way = 1.0, z = 0.0, medium = 1.0;
    int i = 0, turns = 0;
    Ray r = Ray(vec3(entrance, 0.0), vec3(g_slope * norm, 0.0, norm), vec2(0.0), vec2(0.0), 0.0, vec3(1.0), false);
    for (int step = 0; step < 384 && i < g_surfaces; step++) {
        int at = 1 + i * SURFACE;
        vec4 s = lens(at);
        float before = medium, after = way > 0.0 ? lens(at + 3)[g_channel] : i > 0 ? lens(at + 3 - SURFACE)[g_channel] : 1.0;
        bool reflected = (turns == 0 && i == g_pair.x) || (turns == 1 && i == g_pair.y);
        vec3 normal;
        r.p.z -= s.x - z;
        z = s.x;
        if (!(r.d.z * way > 0.0) || !meet(s, lens(at + 1), lens(at + 2), way, r, normal)) return r;
        if (i == g_stop) {
            r.stop = r.p.xy / u_lens.w;
        } else {
            r.relative = max(r.relative, length(r.p.xy) / s.z);
            if (!go_on(at + 4, before, after, reflected, normal, weigh, r)) return r;
        }
        if (reflected) {
            way = -way;
            turns++;
        } else {
            medium = after;
        }
        i += way > 0.0 ? 1 : -1;
    }
    if (!(r.d.z > 0.0)) return r;
    r.sensor = r.p.xy + r.d.xy / r.d.z * (g_sensor_z - z - r.p.z);
    r.arrives = r.sensor == r.sensor && r.relative == r.relative;
    return r;
}

int g_knot;
float g_between;

/* Texel i of the outline, between two knots. */
vec4 knot(int i) { return mix(ghosts(g_knot + i), ghosts(g_knot + KNOT + i), g_between); }

/* lflare__traced_last */
Ray last_ray(float at, float angle, vec4 shape, out vec2 place, out float reached)
{
    float near = 0.0, far = at, edge = 0.0, c = cos(angle), s = sin(angle);
    Ray r;
    for (int tries = 0; tries < 9; tries++) {
        place.y = at * shape.z * s;
        place.x = shape.x + at * shape.y * c + shape.w * at * s * at * s;
        r = trace(place, true);
        if (r.arrives) {
            if (tries == 0 || tries == 8) break;
            near = at;
        } else {
            far = at;
            edge = 1.0;
        }
        at = tries < 7 ? 0.5 * (near + far) : near;
    }
    r.relative = max(r.relative, r.arrives ? edge : 2.0);
    reached = at;
    return r;
}

float g_lamp; /* lamp's radius times the override's scale */

float soft(float lamp)
{
    lamp *= g_lamp;
    return sqrt(5.0 * (PIXEL_VARIANCE * u_lens.x * u_lens.x + 0.25 * lamp * lamp));
}

/* lflare__patch_ring */
float fringe(float shrink, float lamp, float scale)
{
    return (u_burst[2].w >= 0.0 ? scale : 0.0) * sqrt(0.5 * u_spectrum.y * sqrt(abs(shrink)) * abs(lamp));
}

void main()
{
    int ghost = int(a_instance.x) * GHOST, light = int(a_instance.y) * 4, patch_index = int(a_instance.z), mesh = 0;
    vec4 style0 = ghosts(ghost + 1), style1 = ghosts(ghost + 2), l0 = u_lights[light], l1 = u_lights[light + 1], l2 = u_lights[light + 2];
    vec2 slope = l0.xy, axis = l0.zw;
    vec3 irradiance = l2.yzw * u_strip.y;
    int place = int(u_lights[light + 3].x), outline = ghost + 3;
    gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
    v_irradiance = v_flux = vec3(0.0);
    v_entrance = vec2(0.0);
    v_most = 0.0;
#ifdef PATCH_RIM
    v_iris01 = v_iris2 = vec4(1.0);
    v_rim = vec3(1.0);
    v_bulge = vec4(0.0);
#endif
    if (place < int(u_strip.x)) irradiance *= uintBitsToFloat(texelFetch(u_visibility, ivec2(place, 0), 0).r);
    vec4 h0 = ghosts(outline), h1 = ghosts(outline + 1);
    bool split_mesh = h0.w > 0.0;
    for (; mesh < 2; mesh++) { /* the outline that the patch belongs to */
        int patches = h0.z > 0.0 ? int(h0.x / 4.0) * int(h0.y / 4.0) : 0;
        if (patch_index < patches) break;
        patch_index -= patches;
        outline += OUTLINE;
        h0 = ghosts(outline);
        h1 = ghosts(outline + 1);
    }
    int directions = int(h0.x), rings = int(h0.y), sectors = max(directions / 4, 1), blocks = rings / 4, block = patch_index / sectors;
    bool ragged = h1.x > 0.0;
#ifdef PATCH_STRIP
    bool drawn = ragged || block == blocks - 1;
#else
    bool drawn = !ragged;
#endif
    if (!(l1.y < h0.z) || !drawn || !(irradiance.x + irradiance.y + irradiance.z > 0.0)) return;

    vec4 pair = ghosts(ghost), head = lens(0);
    g_surfaces = int(head.x);
    g_stop = int(head.y);
    g_sensor_z = head.z;
    g_pair = ivec2(pair.xy);
    g_slope = l1.x;
    g_channel = split_mesh ? mesh : 1;
    g_lamp = l1.z * style0.w;
    float at = (1.0 - sqrt(max(1.0 - l1.y / h0.z, 0.0))) * float(KNOTS - 1), scale = style0.w;
    int first = int(min(at, float(KNOTS - 2)));
    g_between = at - float(first);
    g_knot = outline + 2 + first * KNOT;
    vec4 shape = knot(0), whole = knot(1), bounds = knot(2); /* centre, half axes, bend; blur of the iris, radius on the sensor, on the entrance, as it stands */

    /* ghosts smaller than a pixel, or than what diffraction and the lamp leave, grow: see lflare__patch_grow */
    float lamp = whole.x * l1.z, entrance = max(whole.z, 1e-6), wide = min(h1.y / entrance, 0.5 * u_half.x);
    float least = sqrt(2.25 * u_lens.x * u_lens.x + wide * wide + lamp * lamp);
    float grown = (whole.w < 0.0 ? -scale : scale) * max(least - whole.y, 0.0) / entrance;
    float even = clamp(2.0 - scale * whole.y / max(4.0 * u_lens.x, scale * least), 0.0, 1.0);
    float size2 = scale * max(whole.y, least);
    size2 *= size2;
    float wash = PIXEL_VARIANCE * u_lens.x * u_lens.x + 0.25 * g_lamp * g_lamp * whole.x * whole.x, wash5 = max(5.0 * wash, 1e-30);
    float q = sqrt(size2 / wash5), far = 2.0 * wash5 * (0.05 + q * (0.1875 + q * (0.25 + q * (0.125 - 0.0125 * q * q))));
    irradiance *= size2 / (wash5 <= size2 ? size2 + wash : far);

    int row = gl_VertexID / DIRECTIONS, direction = patch_index % sectors * (DIRECTIONS - 1) + gl_VertexID % DIRECTIONS;
    float side = direction > directions ? -1.0 : 1.0, turn = float(direction);
    if (direction > directions) direction = 2 * directions - direction;
    float beside_at = float(direction) * float(SIDES - 1) / float(directions);
    int beside_first = int(min(beside_at, float(SIDES - 2)));
    vec4 beside = mix(knot(3 + beside_first), knot(4 + beside_first), beside_at - float(beside_first)); /* outer, inner, rate, blur */

    /* from where to where the rim reaches, in rings: see lflare__traced_band */
    float about = whole.y / entrance, iris_soft = soft(whole.x), widest = sqrt(u_spectrum.x / u_spectrum.y);
    float inverse = 1.1 / max(scale * beside.z + abs(grown) * whole.z, 1.5 * u_lens.x);
    vec4 width = vec4(iris_soft, soft(beside.w), widest * fringe(about * about, whole.x, scale), widest * fringe(about * about, beside.w, scale)) * inverse;
    width.zw = min(width.zw, 0.4);
    width.zw *= step(width.xy, 8.0 * width.zw);
    vec2 inner = width.xy + 5.0 * width.zw, outer = width.xy + 2.5 * width.zw;
    float begin = float(rings) * max(beside.y - max(inner.x, inner.y) - u_strip.w - 0.04, 0.0), end = float(rings) * (1.0 + max(outer.x, outer.y) + u_strip.w + 0.04);
    if (ragged) {
        begin = float(block) / float(blocks) * end;
        end *= float(block + 1) / float(blocks);
    }
#ifdef PATCH_STRIP
    at = begin + (end - begin) * float(row) / float(BANDS - 1);
#else
    at = min(float(block * (RINGS - 1) + row), begin);
#endif
    float angle = PI * float(direction) / float(directions), reached;
    vec2 ray_at;
    Ray ray = last_ray(at * beside.x / float(rings), angle, shape, ray_at, reached);
    if (direction == 0 || direction == directions) ray_at.y = 0.0;

    /* lflare__traced_shrink */
    vec2 h = 0.3 * shape.yz / float(rings);
    float curved = 0.0;
    vec4 slopes[2];
    bool whole_ray = ray.arrives;
    for (int i = 0; i < 2; i++) {
        vec2 way = i == 0 ? -h : h;
        Ray x = trace(ray_at + vec2(way.x, 0.0), false), y = trace(ray_at + vec2(0.0, way.y), false);
        whole_ray = whole_ray && x.arrives && y.arrives;
        slopes[i] = vec4((x.sensor - ray.sensor) / way.x, (y.sensor - ray.sensor) / way.y);
        curved += (x.relative - ray.relative) / (h.x * h.x) + (y.relative - ray.relative) / (h.y * h.y);
    }
    vec4 middle = 0.5 * (slopes[0] + slopes[1]);
    vec2 shrinks = vec2(slopes[0].x * slopes[0].w - slopes[0].y * slopes[0].z, slopes[1].x * slopes[1].w - slopes[1].y * slopes[1].z);
    float shrink = whole_ray ? middle.x * middle.w - middle.y * middle.z : 0.0, spread = max(whole_ray ? abs(shrinks.y - shrinks.x) / 0.3 : 1e30, 1e-20);
    float flat_share = max(even, clamp(2.0 - abs(shrink) / spread, 0.0, 1.0)), chord = PI / float(directions) * reached * (abs(cos(angle)) > 0.7 ? shape.z : shape.y);
    vec3 flux = (split_mesh ? vec3(equal(ivec3(0, 1, 2), ivec3(mesh))) : vec3(1.0)) * ray.weight * irradiance * style0.rgb;
    if (flat_share < 1.0) v_irradiance = (1.0 - flat_share) * flux / max(abs(shrink), spread);
    v_flux = flat_share * flux * scale * scale;
    v_most = 8.0 / ((whole_ray ? spread : max(about * about, 1e-20)) * scale * scale);
    float centre = bounds.z;
    vec2 in_at = vec2(ray_at.x - shape.x, side * ray_at.y), local = vec2(centre + scale * (ray.sensor.x - centre), scale * side * ray.sensor.y) + grown * in_at;
    v_entrance = vec2(in_at.x * axis.x - in_at.y * axis.y, in_at.x * axis.y + in_at.y * axis.x);
#ifdef PATCH_RIM
    vec2 iris = mat2(axis.x, axis.y, -axis.y * side, axis.x * side) * ray.stop;
    v_iris01 = vec4(iris, iris);
    v_iris2 = vec4(iris, soft(beside.w) / u_lens.x, iris_soft / u_lens.x);
    v_rim = vec3(ray.relative);
    v_bulge = vec4(turn, 4.0 * clamp(0.125 * chord * chord * curved, 0.0, 0.05), vec2(fringe(shrink, whole.x, scale), fringe(shrink, beside.w, scale)) / u_lens.x);
#endif
    vec2 position = vec2(local.x * axis.x - local.y * axis.y, local.x * axis.y + local.y * axis.x);
    position += u_lens.y * (style1.x * slope + style1.y * vec2(-slope.y, slope.x));
    gl_Position = vec4(-(position - u_half.zw) / u_half.xy, 0.0, 1.0);
}
