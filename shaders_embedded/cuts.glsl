/* Share of light where soft edges meet, for three wavelengths at once: see lflare__both. */
/* the two least coverages and their inward normals */
vec3 c1, c2, nx1, ny1, nx2, ny2;

void uncut()
{
    c1 = c2 = vec3(1.0);
    nx1 = ny1 = nx2 = ny2 = vec3(0.0);
}

void cut(vec3 t, vec3 nx, vec3 ny)
{
    t = clamp(t, -1.0, 1.0);
    vec3 c = 0.5 + t * (0.75 - 0.25 * t * t);
    bvec3 first = lessThan(c, c1), second = lessThan(c, c2);
    c2 = mix(mix(c2, c, second), c1, first);
    nx2 = mix(mix(nx2, nx, second), nx1, first);
    ny2 = mix(mix(ny2, ny, second), ny1, first);
    c1 = mix(c1, c, first);
    nx1 = mix(nx1, nx, first);
    ny1 = mix(ny1, ny, first);
}

uniform highp sampler2D u_mask; /* of the iris: see lflare__iris_mask; used where u_strip.z says so */

vec3 mask(vec3 x, vec3 y, vec3 soft)
{
    vec3 lod = clamp(log2(1.55 * 256.0 * soft), 0.0, 9.0);
    return vec3(textureLod(u_mask, vec2(x.x, y.x) * 0.5 + 0.5, lod.x).r, textureLod(u_mask, vec2(x.y, y.y) * 0.5 + 0.5, lod.y).r,
                textureLod(u_mask, vec2(x.z, y.z) * 0.5 + 0.5, lod.z).r);
}

vec3 within()
{
    vec3 rho = clamp(nx1 * nx2 + ny1 * ny2, -1.0, 1.0), both = c1 * c2;
    vec3 less = both - rho * (max(c1 + c2 - 1.0, 0.0) - both), more = both + rho * (c1 - both);
    return mix(less, more, greaterThan(rho, vec3(0.0)));
}
