/* What vertices and fragments of meshes share. */
uniform highp sampler2D u_ghosts; /* rows of the ghosts: see each vertex shader; their colours, where there are more than three wavelengths */

const float PIXEL_VARIANCE = 0.715 * 0.715 / 5.0;
const int SPECTRUM_ROWS = 37, SPECTRUM_KNOTS = 12;

vec4 ghosts(int i) { return texelFetch(u_ghosts, ivec2(i % 1024, i / 1024), 0); }

/* Shares of three wavelengths in the places of one of many, and what it adds to RGB. */
vec3 place_shares(int i) { return u_spectral[2 * i].xyz; }
vec3 colour_of(int i) { return u_spectral[2 * i + 1].xyz; }

/* A row of a ghost's colours at a place in the bundle; spectrum: texel of the field angle before the light's, way to the next. */
float spectrum_at(vec2 spectrum, int row, vec2 bundle)
{
    int i = int(spectrum.x) + row;
    return dot(mix(ghosts(i), ghosts(i + SPECTRUM_ROWS), spectrum.y), vec4(1.0, bundle.x, bundle.x * bundle.x, bundle.y * bundle.y));
}

#ifdef PATCH_VERTEX
/* lflare__style_tint: what a ramp of `left` + 1 stops, the first at texel `at`, does to the tint at a field angle */
vec3 ramp(int at, int left, float angle)
{
    vec4 a = ghosts(at), b = left > 0 ? ghosts(at + 1) : a;
    for (; left > 1 && angle > b.w; left--) {
        at++;
        a = b;
        b = ghosts(at + 1);
    }
    return mix(a.rgb, b.rgb, left > 0 ? clamp((angle - a.w) / (b.w - a.w), 0.0, 1.0) : 0.0);
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

/* lflare__patch_grow: ghosts smaller than a pixel, or than what diffraction and the lamp leave, grow, by the first, mm a mm on the entrance; how
   much triangles decide its irradiance; what the light is multiplied by. turned: the override's scale, negative if the ghost stands upside down */
vec3 grow(float radius, float entrance, float lamp, float diffraction, float turned, float lamp_radius)
{
    float scale = abs(turned), spread = min(diffraction / entrance, 0.5 * u_half.x), disc = lamp * lamp_radius;
    float least = sqrt(2.25 * u_lens.x * u_lens.x + spread * spread + disc * disc), size2 = scale * max(radius, least);
    size2 *= size2;
    float wash = PIXEL_VARIANCE * u_lens.x * u_lens.x + 0.25 * g_lamp * g_lamp * lamp * lamp, wash5 = max(5.0 * wash, 1e-30);
    float q = sqrt(size2 / wash5), wide = 2.0 * wash5 * (0.05 + q * (0.1875 + q * (0.25 + q * (0.125 - 0.0125 * q * q))));
    return vec3(turned * max(least - radius, 0.0) / entrance, clamp(2.0 - scale * radius / max(4.0 * u_lens.x, scale * least), 0.0, 1.0), size2 / (wash5 <= size2 ? size2 + wash : wide));
}

/* How far within and beyond the outline edges of iris and rim reach, from softness and fringes of both: see lflare__profile_make */
vec2 edges(vec4 width)
{
    width.zw = min(width.zw, 0.4);
    width.zw *= step(width.xy, 8.0 * width.zw);
    vec2 inner = width.xy + 5.0 * width.zw, outer = width.xy + 2.5 * width.zw;
    return vec2(max(inner.x, inner.y), max(outer.x, outer.y));
}

/* lflare__patch_spectrum */
vec2 spectrum_of(int ghost, float angle, float hidden)
{
    float at = (1.0 - sqrt(max(1.0 - angle / hidden, 0.0))) * float(SPECTRUM_KNOTS - 1);
    int first = int(min(at, float(SPECTRUM_KNOTS - 2)));
    return vec2(int(u_bands.y) + (ghost * SPECTRUM_KNOTS + first) * SPECTRUM_ROWS, at - float(first));
}

vec2 bundle_of(vec2 spectrum, vec2 entrance)
{
    vec3 b = mix(ghosts(int(spectrum.x)), ghosts(int(spectrum.x) + SPECTRUM_ROWS), spectrum.y).xyz;
    return vec2((entrance.x - b.x) / max(b.y, 1e-9), entrance.y / max(b.z, 1e-9));
}

/* lflare__patch_light, of white light: what a mesh for wavelength `mesh`, or for all (below 0), gives its channels */
vec3 channels(vec2 spectrum, vec2 bundle, int mesh, vec3 weight)
{
    if (u_bands.x > 0.0) return mesh < 0 ? vec3(1.0) : max(spectrum_at(spectrum, 1 + mesh, bundle), 0.0) * colour_of(mesh);
    return mesh < 0 ? weight : weight * vec3(equal(ivec3(0, 1, 2), ivec3(mesh)));
}

/* What all wavelengths add up to where nothing cuts: lflare__patch_colour. */
vec3 summed(vec2 spectrum, vec2 bundle, int mesh)
{
    if (u_bands.x == 0.0 || mesh >= 0) return vec3(1.0);
    return vec3(spectrum_at(spectrum, SPECTRUM_ROWS - 3, bundle), spectrum_at(spectrum, SPECTRUM_ROWS - 2, bundle), spectrum_at(spectrum, SPECTRUM_ROWS - 1, bundle));
}
#endif
