/* Share of light where soft edges meet, for three wavelengths at once: see lflare__both. FRINGES: with them, and with the mask;
   compiled apart, since some drivers look up textures on branches not taken. */
uniform highp sampler2D u_ringing; /* see lflare_ringing_make */
uniform highp sampler2D u_mask;    /* of the iris: see lflare__iris_mask; where u_strip.z says so */
uniform highp sampler2D u_fringed; /* as ghosts show it: see lflare_fringed_begin */

/* the two edges that cut most: distance over reach, inward normals; softness and fringes. What they leave is looked up at the end. */
vec3 t1, t2, nx1, ny1, nx2, ny2;
#ifdef FRINGES
vec3 s1, s2, r1, r2;
#endif

void uncut()
{
    t1 = t2 = vec3(1.0);
    nx1 = ny1 = nx2 = ny2 = vec3(0.0);
#ifdef FRINGES
    s1 = s2 = vec3(1.0);
    r1 = r2 = vec3(0.0);
#endif
}

void cut(Profile p, vec3 d, vec3 nx, vec3 ny)
{
    vec3 t = max(d / mix(p.outer, p.inner, greaterThan(d, vec3(0.0))), -1.0);
    bvec3 first = lessThan(t, t1), second = lessThan(t, t2);
    t2 = mix(mix(t2, t, second), t1, first);
    nx2 = mix(mix(nx2, nx, second), nx1, first);
    ny2 = mix(mix(ny2, ny, second), ny1, first);
    t1 = mix(t1, t, first);
    nx1 = mix(nx1, nx, first);
    ny1 = mix(ny1, ny, first);
#ifdef FRINGES
    s2 = mix(mix(s2, p.soft, second), s1, first);
    r2 = mix(mix(r2, p.ring, second), r1, first);
    s1 = mix(s1, p.soft, first);
    r1 = mix(r1, p.ring, first);
#endif
}

vec3 plain_at(vec3 t)
{
    t = clamp(t, -1.0, 1.0);
    return 0.5 + t * (0.75 - 0.25 * t * t);
}

#ifdef FRINGES
/* lflare__profile_at, at a distance over reach */
vec3 profile_at(vec3 t, vec3 soft, vec3 ring)
{
    vec3 inner = soft + 5.0 * max(ring, 0.0), outer = soft + 2.5 * abs(ring), d = t * mix(outer, inner, greaterThan(t, vec3(0.0)));
    vec3 beyond = 1.25 * max(-ring, 0.0), plain = plain_at((d + beyond) / (soft + beyond));
    if (all(lessThanEqual(ring, vec3(0.0)))) return plain;
    vec3 blur = soft / max(ring, vec3(1e-20)), u = clamp((d + outer) / (inner + outer), 0.0, 1.0), v = min(blur / (blur + 2.0) * 1.25, 1.0);
    u = (u * 255.0 + 0.5) / 256.0;
    v = (v * 15.0 + 0.5) / 16.0;
    vec3 fringes = vec3(texture(u_ringing, vec2(u.x, v.x)).r, texture(u_ringing, vec2(u.y, v.y)).r, texture(u_ringing, vec2(u.z, v.z)).r);
    return mix(plain, fringes, greaterThan(ring, vec3(0.0)));
}
#endif

#ifdef FRINGES
/* lflare__fringed_level, between two levels: `lod` */
float fringed(float view, float lod, vec2 at)
{
    float edge = exp2(ceil(lod)) / 512.0;
    return 2.0 * textureLod(u_fringed, (vec2(mod(view, 5.0), floor(view / 5.0)) + clamp(at, edge, 1.0 - edge)) / 5.0, lod).r;
}

/* lflare__iris_mask */
float mask_at(float x, float y, float soft, float ring)
{
    vec2 at = vec2(x, y) * 0.5 + 0.5;
    float lod = clamp(log2(0.894 * 256.0 * soft), 0.0, 9.0), plain = textureLod(u_mask, at, lod).r;
    if (mod(u_strip.z, 2.0) == 1.0 || ring == 0.0) return plain;
    float view = 5.0 * log2(0.4 / ring), fade = clamp(5.8 - 0.2 * view, 0.0, 1.0);
    lod = max(lod - 1.0, 0.0);
    view = min(view, 24.0);
    float first = min(floor(view), 23.0), fine = fringed(first, lod, at);
    return mix(plain, mix(fine, fringed(first + 1.0, lod, at), view - first), fade);
}

vec3 mask(vec3 x, vec3 y, Profile p)
{
    return vec3(mask_at(x.x, y.x, p.soft.x, p.ring.x), mask_at(x.y, y.y, p.soft.y, p.ring.y), mask_at(x.z, y.z, p.soft.z, p.ring.z));
}
#endif

vec3 within()
{
#ifdef FRINGES
    vec3 c1 = profile_at(t1, s1, r1), c2 = profile_at(t2, s2, r2);
#else
    vec3 c1 = plain_at(t1), c2 = plain_at(t2);
#endif
    vec3 rho = clamp(nx1 * nx2 + ny1 * ny2, -1.0, 1.0), both = c1 * c2;
    vec3 less = both - rho * (max(min(c1, 1.0) + min(c2, 1.0) - 1.0, 0.0) - both), more = both + rho * (c1 - both);
    return mix(mix(less, more, greaterThan(rho, vec3(0.0))), c1, greaterThanEqual(t2, vec3(1.0)));
}
