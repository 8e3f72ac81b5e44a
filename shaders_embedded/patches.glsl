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
