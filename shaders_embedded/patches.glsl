/* What vertices and fragments of meshes share. */
uniform highp sampler2D u_ghosts; /* rows of the ghosts: see each vertex shader; their colours, where there are more than three wavelengths */

const float PIXEL_VARIANCE = 0.715 * 0.715 / 5.0;
const int SPECTRUM_ROWS = 36;

vec4 ghosts(int i) { return texelFetch(u_ghosts, ivec2(i % 1024, i / 1024), 0); }

/* Row i of a ghost's colours. */
vec4 colours(int ghost, int i) { return ghosts(int(u_bands.y) + ghost * SPECTRUM_ROWS + i); }

/* Shares of three wavelengths in one, for places and for weights. */
vec3 place_shares(int i) { return u_spectral[2 * i].xyz; }
vec3 weight_shares(int i) { return u_spectral[2 * i + 1].xyz; }

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

/* lflare__patch_light, of white light: what a mesh for wavelength `mesh`, or for all (below 0), gives its channels */
vec3 channels(int ghost, int mesh, vec3 weight)
{
    if (u_bands.x > 0.0 && mesh >= 0) return dot(weight_shares(mesh), weight) * colours(ghost, mesh).rgb;
    return mesh < 0 ? weight : weight * vec3(equal(ivec3(0, 1, 2), ivec3(mesh)));
}

/* What three wavelengths add up to where nothing cuts: lflare__patch_colour. */
vec3 summed(int ghost, int mesh, vec3 lit)
{
    if (u_bands.x == 0.0 || mesh >= 0) return lit;
    return lit.x * colours(ghost, SPECTRUM_ROWS - 3).rgb + lit.y * colours(ghost, SPECTRUM_ROWS - 2).rgb + lit.z * colours(ghost, SPECTRUM_ROWS - 1).rgb;
}
#endif
