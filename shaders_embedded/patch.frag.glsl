out vec4 o_color;
/* at a pixel of which a sliver has a sample but not the middle, what lies beyond the sliver is not light: centroids */
centroid in vec3 v_irradiance; /* to it comes */
centroid in vec3 v_flux;       /* over the area on the sensor that a triangle's area on the entrance, mm, shrinks to, */
centroid in float v_most;      /* at most by this: slivers next to caustics that hit a pixel's middle would sparkle */
in vec2 v_entrance;            /* place */

vec3 lit()
{
    vec2 ex = dFdx(v_entrance), ey = dFdy(v_entrance);
    return v_irradiance + v_flux * min(abs(ex.x * ey.y - ex.y * ey.x) / (u_lens.x * u_lens.x), v_most);
}

#ifndef PATCH_RIM
void main() { o_color = vec4(lit(), 0.0); } /* the vertices' colours are whole */
#else
flat in vec4 v_light; /* the light's colour; how many wavelengths the three heights stand for, if they are more */
flat in vec2 v_spectrum; /* their colours, */
in vec2 v_bundle;        /* and where in the bundle */
/* Coverage within iris and rim where a mesh's heights say so: see lflare__rim_coverage. */
in vec4 v_iris01;  /* red's and green's place on the iris */
in vec4 v_iris2;   /* blue's; width of the soft rim, pixels; that of the iris */
in vec3 v_rim;
in vec4 v_bulge;   /* counts directions; 4 times how far rims bulge between them; fringes at the iris and at the rim, pixels */

/* lflare__blend: many wavelengths are softened as far as the edge moves from one to the next */
void cut_slope(vec3 over, vec3 gx, vec3 gy, float soft, float ring, float softness, bool is_dark, bool blend, vec3 waves)
{
    vec3 g = max(sqrt(gx * gx + gy * gy), vec3(1e-20)), pixels = min(g, 0.6);
    Profile p = profile_over(soft * pixels, ring * pixels, blend ? length(vec2(softness, 0.3575 * (over.z - over.x))) : softness, waves);
    if (is_dark) p = dark(p);
    cut(p, -over, -gx / g, -gy / g);
}

/* What iris and rims leave of three wavelengths. */
vec3 covered(vec3 hx, vec3 hy, vec3 rim, bool blend, vec3 waves)
{
    vec3 xx = dFdx(hx), xy = dFdy(hx), yx = dFdx(hy), yy = dFdy(hy), rim_x = dFdx(rim), rim_y = dFdy(rim);
    float turn = fract(v_bulge.x), bend = v_bulge.y * (1.0 - 2.0 * turn);
    int blades = int(u_spectrum.w);
    uncut();
    for (int i = 0; i < max(blades, 1); i++) {
        vec4 b = blades > 0 ? u_blades[i] : vec4(0.0, 0.0, 0.0, 1.0);
        if (b.w > 0.0) {
            vec3 ax = hx + b.x * b.z, ay = hy + b.y * b.z, far = sqrt(ax * ax + ay * ay), inverse = 1.0 / max(far, vec3(1e-20));
            cut_slope(far - b.w, (ax * xx + ay * yx) * inverse, (ax * xy + ay * yy) * inverse, v_iris2.w, v_bulge.z, u_strip.w, u_strip.z > 2.0, blend, waves);
        } else {
            cut_slope(b.x * hx + b.y * hy - b.z, b.x * xx + b.y * yx, b.x * xy + b.y * yy, v_iris2.w, v_bulge.z, u_strip.w, u_strip.z > 2.0, blend, waves);
        }
    }
    cut_slope(rim - 1.0 - v_bulge.y * turn * (1.0 - turn), rim_x - bend * dFdx(v_bulge.x), rim_y - bend * dFdy(v_bulge.x), v_iris2.z, v_bulge.w, 0.0, false, blend, waves);
    vec3 open = within();
#ifdef FRINGES
    if (u_strip.z > 0.0) {
        vec3 slope = min(sqrt(0.5 * (xx * xx + xy * xy + yx * yx + yy * yy)), 0.6);
        open *= mask(hx, hy, profile_over(v_iris2.w * slope, v_bulge.z * slope, 0.0, waves));
    }
#endif
    return open;
}

void main()
{
    vec3 hx = vec3(v_iris01.xz, v_iris2.x), hy = vec3(v_iris01.yw, v_iris2.y), light = lit(), sum = vec3(0.0);
    int count = int(v_light.w);
    if (count == 0) sum = light * covered(hx, hy, v_rim, false, sqrt(u_spectrum.xyz / u_spectrum.y));
    for (int i = 0; i < count; i += 3) { /* three at a time */
        mat3 places = mat3(place_shares(i), place_shares(i + 1), place_shares(i + 2));
        vec3 waves = sqrt(vec3(u_spectral[2 * i].w, u_spectral[2 * i + 2].w, u_spectral[2 * i + 4].w) / u_spectrum.y);
        vec3 open = max(vec3(spectrum_at(v_spectrum, 1 + i, v_bundle), spectrum_at(v_spectrum, 2 + i, v_bundle), spectrum_at(v_spectrum, 3 + i, v_bundle)), 0.0);
        open *= max(light, 0.0) * covered(hx * places, hy * places, v_rim * places, true, waves);
        sum += open.x * colour_of(i) + open.y * colour_of(i + 1) + open.z * colour_of(i + 2);
    }
    o_color = vec4(sum * v_light.rgb, 0.0);
}
#endif
