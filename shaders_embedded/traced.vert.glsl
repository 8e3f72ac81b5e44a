/* One patch of one traced ghost for one light: lflare__traced_resolve on the GPU (H 4). Programs as for patch.vert.glsl; see there, too,
   for what vertices are called. */
uniform highp sampler2D u_traced_lens;   /* per surface: surface, its terms, film */
/* u_ghosts: per ghost steps' place and number, way to the sensor; style, outlines; then steps */
uniform highp usampler2D u_visibility;

invariant gl_Position; /* both programs put shared vertices on the same pixels */
in uvec4 a_instance; /* ghost, light, patch, band: see lflare_instance */

const int DIRECTIONS = 9, RINGS = 5, BANDS = 3, ROW = 1024, SURFACE = 131, STYLE = 11, GHOST = 796 + STYLE, OUTLINE = 265, KNOTS = 12, KNOT = 22, SIDES = 17;
const float PI = 3.14159265;

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

vec4 lens(int i) { return texelFetch(u_traced_lens, ivec2(i % ROW, i / ROW), 0); }

int g_steps, g_count;
float g_sensor, g_slope;
mat4 g_shares; /* of the three wavelengths, for each of four rays */

/* Four rays at once; the lens is looked up once for all. */
struct Rays {
    vec4 x, y, z, dx, dy, dz, stop_x, stop_y, sensor_x, sensor_y, relative; /* relative: squared until they land */
    bvec4 arrives;
};

float term(vec4 a, vec4 b, int j) { return j < 4 ? a[j] : b[j - 4]; }

bvec4 both(bvec4 a, bvec4 b) { return bvec4(a.x && b.x, a.y && b.y, a.z && b.z, a.w && b.w); }

/* lflare__traced_meet */
void meet(vec4 s, int surface, float way, bool bent, inout Rays r, out vec4 nx, out vec4 ny, out vec4 nz)
{
    float c = s.y, k = s.w;
    vec4 t = r.z / r.dz;
    r.x -= t * r.dx;
    r.y -= t * r.dy;
    vec4 u = c * (r.dx * r.dx + r.dy * r.dy + k * r.dz * r.dz), v = c * (r.x * r.dx + r.y * r.dy) - r.dz, e = c * (r.x * r.x + r.y * r.y), root = v * v - u * e;
    bvec4 meets = greaterThanEqual(root, vec4(0.0));
    t = e / (way * sqrt(max(root, 0.0)) - v);
    if (bent) t = mix(vec4(0.0), t, meets);
    else r.arrives = both(r.arrives, meets);
    r.x += t * r.dx;
    r.y += t * r.dy;
    r.z = t * r.dz;
    nx = ny = vec4(c);
    nz = c * k * r.z - 1.0;
    if (bent) {
        vec4 a = lens(surface * SURFACE + 1), b = lens(surface * SURFACE + 2);
        float inverse = s.z * s.z;
        for (int pass = 0; pass < 6; pass++) {
            vec4 r2 = r.x * r.x + r.y * r.y, left = 1.0 - k * c * c * r2, conic = sqrt(max(left, 1e-6)), at = r2 * inverse, sag = vec4(0.0), slope = vec4(0.0);
            for (int j = 7; j >= 0; j--) {
                slope = slope * at + sag;
                sag = sag * at + term(a, b, j);
            }
            slope = slope * at + sag;
            sag = sag * at + c * r2 / (1.0 + conic);
            nx = c / conic + 2.0 * slope * inverse;
            r.arrives = both(r.arrives, greaterThanEqual(left, vec4(0.0)));
            t = (sag - r.z) / (r.dz - nx * (r.x * r.dx + r.y * r.dy));
            r.x += t * r.dx;
            r.y += t * r.dy;
            r.z += t * r.dz;
        }
        ny = nx;
        nz = vec4(-1.0);
    }
    r.arrives = both(r.arrives, lessThan(nz, vec4(0.0))); /* past the equator: the other sheet */
    nx *= r.x;
    ny *= r.y;
    if (k != 1.0 || bent) {
        t = inversesqrt(nx * nx + ny * ny + nz * nz);
        nx *= t;
        ny *= t;
        nz *= t;
    }
}

/* lflare__traced_pass, for what the first of them brings the film, too */
void go_on(vec4 eta, bool reflected, float way, vec4 nx, vec4 ny, vec4 nz, inout Rays r, out float film_at)
{
    vec4 along = r.dx * nx + r.dy * ny + r.dz * nz, beyond = 1.0 - eta * eta * (1.0 - along * along);
    film_at = eta.x > 1.0 ? sqrt(max(beyond.x, 0.0)) : abs(along.x);
    vec4 kept = vec4(1.0), more = -2.0 * along;
    if (!reflected) {
        r.arrives = both(r.arrives, greaterThanEqual(beyond, vec4(0.0)));
        kept = eta;
        more = -way * sqrt(max(beyond, 0.0)) - eta * along;
    }
    r.dx = kept * r.dx + more * nx;
    r.dy = kept * r.dy + more * ny;
    r.dz = kept * r.dz + more * nz;
}

Rays rays_at(vec4 x, vec4 y)
{
    float norm = inversesqrt(1.0 + g_slope * g_slope);
    return Rays(x, y, vec4(0.0), vec4(g_slope * norm), vec4(0.0), vec4(norm), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), bvec4(true));
}

void pass_step(vec4 s, vec4 steps, int code, mat4 shares, inout Rays r, out float film_at)
{
    float way = (code & 8) != 0 ? -1.0 : 1.0;
    vec4 nx, ny, nz;
    film_at = 1.0;
    r.z -= s.x;
    r.arrives = both(r.arrives, greaterThan(r.dz * way, vec4(0.0)));
    meet(s, code / 16, way, (code & 4) != 0, r, nx, ny, nz);
    if ((code & 3) == 2) {
        r.stop_x = r.x / u_lens.w;
        r.stop_y = r.y / u_lens.w;
    } else if ((code & 2) != 0) {
        r.relative = max(r.relative, (r.x * r.x + r.y * r.y) / (u_lens.w * u_lens.w));
    } else {
        r.relative = max(r.relative, (r.x * r.x + r.y * r.y) * (s.z * s.z));
        go_on(vec4(steps.xyz, 0.0) * shares, (code & 1) != 0, way, nx, ny, nz, r, film_at);
    }
}

void land(inout Rays r)
{
    vec4 t = (g_sensor - r.z) / r.dz;
    r.relative = sqrt(r.relative);
    r.sensor_x = r.x + t * r.dx;
    r.sensor_y = r.y + t * r.dy;
    vec4 sum = r.sensor_x + r.sensor_y + r.relative;
    r.arrives = both(both(r.arrives, greaterThan(r.dz, vec4(0.0))), equal(sum, sum));
}

/* lflare__traced_ray_make for the rays of three wavelengths, the vertex's own first, and for its neighbours; shares of light that the films let go on */
vec3 trace(inout Rays own, inout Rays near)
{
    vec3 weight = vec3(1.0);
    mat4 alike = mat4(g_shares[0], g_shares[0], g_shares[0], g_shares[0]);
    for (int i = 0; i < g_count; i++) {
        vec4 s = ghosts(g_steps + 2 * i), steps = ghosts(g_steps + 2 * i + 1);
        int code = int(steps.w);
        float film_at, unused;
        pass_step(s, steps, code, g_shares, own, film_at);
        pass_step(s, steps, code, alike, near, unused);
        if ((code & 2) == 0) {
            float at = 127.0 * film_at;
            int first = int(clamp(at, 0.0, 126.0)), row = code / 16 * SURFACE + 3 + first;
            vec3 share = mix(lens(row).rgb, lens(row + 1).rgb, at - float(first));
            weight *= (code & 1) != 0 ? share : vec3(1.0) - share;
        }
    }
    land(own);
    land(near);
    return weight;
}

/* Whether the ray at a place arrives. */
bool arrives_at(vec2 place)
{
    Rays r = rays_at(vec4(place.x), vec4(place.y));
    float unused;
    for (int i = 0; i < g_count && r.arrives.x; i++) {
        vec4 steps = ghosts(g_steps + 2 * i + 1);
        pass_step(ghosts(g_steps + 2 * i), steps, int(steps.w), g_shares, r, unused);
    }
    land(r);
    return r.arrives.x;
}

int g_knot;
float g_between;

/* Texel i of the outline, between two knots. */
vec4 knot(int i) { return mix(ghosts(g_knot + i), ghosts(g_knot + KNOT + i), g_between); }

vec2 place_at(float at, vec2 toward, vec4 shape)
{
    vec2 p = at * shape.yz * toward;
    return vec2(shape.x + p.x + shape.w * at * toward.y * at * toward.y, p.y);
}

/* lflare__traced_last, once it is known that the ray there does not arrive */
float last_at(float at, vec2 toward, vec4 shape)
{
    float near = 0.0, far = at;
    for (int tries = 1; tries < 8; tries++) {
        at = 0.5 * (near + far);
        if (arrives_at(place_at(at, toward, shape))) near = at;
        else far = at;
    }
    return near;
}

void main()
{
    int ghost = int(a_instance.x) * GHOST, light = int(a_instance.y) * 4, patch_index = int(a_instance.z);
    vec4 style0 = ghosts(ghost + 1), style1 = ghosts(ghost + 2), style2 = ghosts(ghost + 3), l0 = u_lights[light], l1 = u_lights[light + 1], l2 = u_lights[light + 2];
    if (style2.z > 0.0) style0.rgb *= ramp(ghost + 4, int(style2.z) - 1, l1.y);
    vec2 slope = l0.xy, axis = l0.zw;
    vec3 irradiance = l2.yzw * u_strip.y * (1.0 - float(a_instance.w >> 10) / 63.0); /* see lflare_instance */
    int place = int(u_lights[light + 3].x), first = int(a_instance.w & 15u), outline = ghost + 1 + STYLE + OUTLINE;
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
    int code = int(ghosts(outline + 1 + first * KNOT + 2).w), rings = code & 63, directions = (code & 64) != 0 ? 32 : 16; /* lflare__mesh_code, then lflare__code_coarser */
    for (int levels = int(a_instance.w >> 8) & 3; levels > 0; levels--)
        if (rings > 4) rings /= 2;
        else directions = 16;
    bool split_mesh = (code & 128) != 0, ragged = (code & 256) != 0;
    int sectors = directions / 4, blocks = rings / 4, mesh = split_mesh ? patch_index / (sectors * blocks) : -1, block = patch_index / sectors % blocks;
    if (split_mesh && u_bands.x == 0.0) outline = ghost + 1 + STYLE + mesh * OUTLINE;
    vec4 h = ghosts(outline);
#ifdef PATCH_STRIP
    bool drawn = ragged || block == blocks - 1;
#else
    bool drawn = !ragged;
#endif
    if (!(l1.y < h.x) || !drawn || !(irradiance.x + irradiance.y + irradiance.z > 0.0)) return;

    vec4 path = ghosts(ghost);
    g_steps = int(path.x);
    g_count = int(path.y);
    g_sensor = path.z;
    g_slope = l1.x;
    g_lamp = l1.z * style0.w;
    int last_mesh = int(u_bands.x) - 1; /* beside its own a mesh of many wavelengths traces those next to it */
    vec4 lead = u_bands.x > 0.0 ? vec4(place_shares(max(mesh, 0)), 0.0) : vec4(equal(ivec4(mesh), ivec4(0, 1, 2, 3)));
    vec4 before = u_bands.x > 0.0 ? vec4(place_shares(max(mesh - 1, 0)), 0.0) : lead, behind = u_bands.x > 0.0 ? vec4(place_shares(min(mesh + 1, last_mesh)), 0.0) : lead;
    g_shares = split_mesh ? mat4(lead, before, behind, lead) : mat4(vec4(0.0, 1.0, 0.0, 0.0), vec4(1.0, 0.0, 0.0, 0.0), vec4(0.0, 0.0, 1.0, 0.0), vec4(0.0, 1.0, 0.0, 0.0));
    float at = (1.0 - sqrt(max(1.0 - l1.y / h.x, 0.0))) * float(KNOTS - 1), scale = style0.w;
    g_between = at - float(first);
    g_knot = outline + 1 + first * KNOT;
    vec4 shape = ragged ? ghosts(g_knot + 4) : knot(0), whole = knot(1), bounds = knot(2), brighter = knot(3); /* centre, half axes, bend; blur of the iris, radius on the sensor, on the entrance, as it stands */

    /* ghosts smaller than a pixel, or than what diffraction and the lamp leave, grow: see lflare__patch_grow */
    float entrance = max(whole.z, 1e-6);
    vec3 growth = grow(whole.y, entrance, whole.x, h.y, whole.w < 0.0 ? -scale : scale, l1.z);
    float grown = growth.x, even = growth.y, gain = growth.z;

    int row = gl_VertexID / DIRECTIONS, direction = patch_index % sectors * (DIRECTIONS - 1) + gl_VertexID % DIRECTIONS;
    float side = direction > directions ? -1.0 : 1.0, turn = float(direction);
    if (direction > directions) direction = 2 * directions - direction;
    float beside_at = float(direction) * float(SIDES - 1) / float(directions);
    int beside_first = int(min(beside_at, float(SIDES - 2)));
    vec4 beside = mix(knot(5 + beside_first), knot(6 + beside_first), beside_at - float(beside_first)); /* outer, inner, rate, blur */

    /* from where to where the rim reaches, in rings: see lflare__traced_band */
    float about = whole.y / entrance, iris_soft = soft(whole.x), widest = sqrt(u_spectrum.x / u_spectrum.y);
    float inverse = 1.1 / max(scale * beside.z + abs(grown) * whole.z, 1.5 * u_lens.x);
    vec2 reach = edges(vec4(iris_soft, soft(beside.w), widest * fringe(about * about, whole.x, scale), widest * fringe(about * about, beside.w, scale)) * inverse);
    float begin = float(rings) * max(beside.y - reach.x - u_strip.w - 0.04, 0.0), end = float(rings) * (1.0 + reach.y + u_strip.w + 0.04);
    if (ragged) {
        begin = float(block * (RINGS - 1));
        end = begin + float(RINGS - 1);
        beside.x = 1.0;
    }
#ifdef PATCH_STRIP
    at = begin + (end - begin) * float(row) / float(BANDS - 1);
#else
    at = min(float(block * (RINGS - 1) + row), begin);
#endif
    float angle = PI * float(direction) / float(directions), edge = 0.0;
    vec2 toward = vec2(cos(angle), direction == 0 || direction == directions ? 0.0 : sin(angle)), h2 = 0.3 * shape.yz / float(rings), ray_at;
    vec4 ways = vec4(-h2.x, h2.x, -h2.y, h2.y);
    vec3 weight;
    Rays own, near;
    at *= beside.x / float(rings);
    for (int pass = 0; pass < 2; pass++) {
        ray_at = place_at(at, toward, shape);
        own = rays_at(ray_at.x + vec4(0.0, 0.0, 0.0, h2.x), ray_at.y + vec4(0.0, 0.0, 0.0, h2.y)); /* at the last, of the vertex's wavelength, its corner */
        near = rays_at(ray_at.x + vec4(ways.xy, 0.0, 0.0), ray_at.y + vec4(0.0, 0.0, ways.zw));
        weight = trace(own, near);
        if (own.arrives.x || pass == 1) break;
        at = last_at(at, toward, shape);
        edge = 1.0;
    }
    own.relative.x = own.arrives.x ? max(own.relative.x, edge) : 2.0;

    /* lflare__traced_slopes */
    bool whole_ray = own.arrives.x && own.arrives.w && all(near.arrives);
    vec4 x = near.sensor_x - own.sensor_x.x, y = near.sensor_y - own.sensor_y.x, more = (near.relative - own.relative.x) / (ways * ways);
    float curved = more.x + more.y + more.z + more.w;
    vec4 middle = 0.5 * vec4((x.y - x.x) / h2.x, (y.y - y.x) / h2.x, (x.w - x.z) / h2.y, (y.w - y.z) / h2.y);
    vec4 bent = vec4(vec2(x.x + x.y, y.x + y.y) / (h2.x * h2.x), vec2(x.z + x.w, y.z + y.w) / (h2.y * h2.y));
    vec2 twist = vec2(own.sensor_x.w - near.sensor_x.y - x.w, own.sensor_y.w - near.sensor_y.y - y.w) / (h2.x * h2.y);
    vec2 grows = vec2(bent.x * middle.w + middle.x * twist.y - bent.y * middle.z - middle.y * twist.x,
                      twist.x * middle.w + middle.x * bent.w - twist.y * middle.z - middle.y * bent.z);
    vec2 radial = shape.yz * toward * beside.x / float(rings), around = shape.yz * vec2(-toward.y, toward.x) * (PI / float(directions) * at);
    float shrink = whole_ray ? middle.x * middle.w - middle.y * middle.z : 0.0;
    float spread = whole_ray ? max(max(abs(dot(grows, radial)), abs(dot(grows, around))), 1e-20) : 1e30;
    float flat_share = max(even, clamp(2.0 - abs(shrink) / spread, 0.0, 1.0)), chord = length(around);
    if (!split_mesh) weight.rb *= brighter.xy;
    vec2 spectrum = u_bands.x > 0.0 ? spectrum_of(int(a_instance.x), l1.y, h.x) : vec2(0.0), bundle = u_bands.x > 0.0 ? bundle_of(spectrum, ray_at) : vec2(0.0);
    vec3 flux = channels(spectrum, bundle, mesh, weight) * gain, light_colour = irradiance * style0.rgb;
#ifndef PATCH_RIM
    flux *= summed(spectrum, bundle, mesh) * light_colour;
#endif
    if (flat_share < 1.0) v_irradiance = (1.0 - flat_share) * flux / max(abs(shrink), spread);
    v_flux = flat_share * flux * scale * scale;
    v_most = 8.0 / ((whole_ray ? spread : max(about * about, 1e-20)) * scale * scale);
    float centre = bounds.z;
    vec2 in_at = vec2(ray_at.x - shape.x, side * ray_at.y), local = vec2(centre + scale * (own.sensor_x.x - centre), scale * side * own.sensor_y.x) + grown * in_at;
    v_entrance = vec2(in_at.x * axis.x - in_at.y * axis.y, in_at.x * axis.y + in_at.y * axis.x);
#ifdef PATCH_RIM
    v_light = vec4(light_colour, split_mesh ? 0.0 : u_bands.x);
    v_spectrum = spectrum;
    v_bundle = bundle;
    float apart = 0.0; /* way to the next wavelength's picture, pixels */
    if (split_mesh && own.arrives.y && own.arrives.z) apart = 0.715 * 0.5 * scale * length(vec2(own.sensor_x.z - own.sensor_x.y, own.sensor_y.z - own.sensor_y.y)) / u_lens.x;
    vec4 off_x = own.sensor_x.x - own.sensor_x, off_y = own.sensor_y.x - own.sensor_y; /* lflare__traced_match */
    bvec4 matched = bvec4(!split_mesh && whole_ray && abs(shrink) > 1e-20);
    matched = both(matched, own.arrives);
    vec4 move_x = clamp(mix(vec4(0.0), (off_x * middle.w - off_y * middle.z) / shrink, matched), -0.5 * shape.y, 0.5 * shape.y);
    vec4 move_y = clamp(mix(vec4(0.0), (off_y * middle.x - off_x * middle.y) / shrink, matched), -0.5 * shape.z, 0.5 * shape.z);
    vec4 slopes_x = vec4(near.stop_x.y - near.stop_x.x, near.stop_y.y - near.stop_y.x, near.relative.y - near.relative.x, 0.0) / (2.0 * h2.x);
    vec4 slopes_y = vec4(near.stop_x.w - near.stop_x.z, near.stop_y.w - near.stop_y.z, near.relative.w - near.relative.z, 0.0) / (2.0 * h2.y);
    vec4 stop_x = mix(own.stop_x.xxxx, own.stop_x, matched) + slopes_x.x * move_x + slopes_y.x * move_y;
    vec4 stop_y = mix(own.stop_y.xxxx, own.stop_y, matched) + slopes_x.y * move_x + slopes_y.y * move_y;
    vec4 rims = max(mix(own.relative.xxxx, own.relative, matched) + slopes_x.z * move_x + slopes_y.z * move_y, 0.0);
    mat2 to_sensor = mat2(axis.x, axis.y, -axis.y * side, axis.x * side);
    v_iris01 = vec4(to_sensor * vec2(stop_x.y, stop_y.y), to_sensor * vec2(stop_x.x, stop_y.x));
    v_iris2 = vec4(to_sensor * vec2(stop_x.z, stop_y.z), length(vec2(soft(beside.w) / u_lens.x, apart)), length(vec2(iris_soft / u_lens.x, apart)));
    v_rim = rims.yxz;
    v_bulge = vec4(turn, 4.0 * clamp(0.125 * chord * chord * curved, 0.0, 0.05), vec2(fringe(shrink, whole.x, scale), fringe(shrink, beside.w, scale)) / u_lens.x);
#endif
    vec2 position = vec2(local.x * axis.x - local.y * axis.y, local.x * axis.y + local.y * axis.x);
    position += u_lens.y * (style1.x * slope + style1.y * vec2(-slope.y, slope.x)) + style2.xy;
    gl_Position = vec4(-(position - u_half.zw) / u_half.xy, 0.0, 1.0);
}
