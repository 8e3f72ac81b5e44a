/* Share of light where soft edges meet, for three wavelengths at once: see lflare__both. FRINGES: with them, and with the mask;
   compiled apart, since some drivers look up textures on branches not taken. */
uniform highp sampler2D u_ringing; /* see lflare_ringing_make */
uniform highp sampler2D u_mask;    /* of the iris: see lflare__iris_mask; where u_strip.z says so */

/* the two edges that cut most: distance over reach, coverage, inward normals */
vec3 t1, t2, c1, c2, nx1, ny1, nx2, ny2;

void uncut()
{
    t1 = t2 = c1 = c2 = vec3(1.0);
    nx1 = ny1 = nx2 = ny2 = vec3(0.0);
}

/* lflare__profile_at */
vec3 profile_at(Profile p, vec3 d)
{
    vec3 t = clamp(d / p.soft, -1.0, 1.0), plain = 0.5 + t * (0.75 - 0.25 * t * t);
#ifdef FRINGES
    if (p.ring == vec3(0.0)) return plain;
    vec3 blur = p.soft / max(p.ring, vec3(1e-20)), u = clamp((d + p.outer) / (p.inner + p.outer), 0.0, 1.0), v = min(blur / (blur + 2.0) * 1.25, 1.0);
    u = (u * 255.0 + 0.5) / 256.0;
    v = (v * 15.0 + 0.5) / 16.0;
    vec3 fringes = vec3(texture(u_ringing, vec2(u.x, v.x)).r, texture(u_ringing, vec2(u.y, v.y)).r, texture(u_ringing, vec2(u.z, v.z)).r);
    return plain + min(7.0 * (0.2143 - p.ring), 1.0) * step(vec3(1e-20), p.ring) * (fringes - plain);
#else
    return plain;
#endif
}

void cut(Profile p, vec3 d, vec3 nx, vec3 ny)
{
    vec3 t = max(d / mix(p.outer, p.inner, greaterThan(d, vec3(0.0))), -1.0), c = profile_at(p, d);
    bvec3 first = lessThan(t, t1), second = lessThan(t, t2);
    t2 = mix(mix(t2, t, second), t1, first);
    c2 = mix(mix(c2, c, second), c1, first);
    nx2 = mix(mix(nx2, nx, second), nx1, first);
    ny2 = mix(mix(ny2, ny, second), ny1, first);
    t1 = mix(t1, t, first);
    c1 = mix(c1, c, first);
    nx1 = mix(nx1, nx, first);
    ny1 = mix(ny1, ny, first);
}

vec3 mask(vec3 x, vec3 y, vec3 soft)
{
    vec3 lod = clamp(log2(1.55 * 256.0 * soft), 0.0, 9.0);
    return vec3(textureLod(u_mask, vec2(x.x, y.x) * 0.5 + 0.5, lod.x).r, textureLod(u_mask, vec2(x.y, y.y) * 0.5 + 0.5, lod.y).r,
                textureLod(u_mask, vec2(x.z, y.z) * 0.5 + 0.5, lod.z).r);
}

vec3 within()
{
    vec3 rho = clamp(nx1 * nx2 + ny1 * ny2, -1.0, 1.0), both = c1 * c2;
    vec3 less = both - rho * (max(min(c1, 1.0) + min(c2, 1.0) - 1.0, 0.0) - both), more = both + rho * (c1 - both);
    return mix(mix(less, more, greaterThan(rho, vec3(0.0))), c1, greaterThanEqual(t2, vec3(1.0)));
}
