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
void main() { o_color = vec4(lit(), 0.0); }
#else
/* Coverage within iris and rim where a mesh's heights say so: see lflare__rim_coverage. */
in vec4 v_iris01;  /* red's and green's place on the iris */
in vec4 v_iris2;   /* blue's; width of the soft rim, pixels; that of the iris */
in vec3 v_rim;
in vec4 v_bulge;   /* counts directions; 4 times how far rims bulge between them; fringes at the iris and at the rim, pixels */

void cut_slope(vec3 over, vec3 gx, vec3 gy, float soft, float ring, float softness, bool is_dark)
{
    vec3 g = max(sqrt(gx * gx + gy * gy), vec3(1e-20)), pixels = min(g, 0.6);
    Profile p = profile_of(soft * pixels, ring * pixels, softness);
    if (is_dark) p = dark(p);
    cut(p, -over, -gx / g, -gy / g);
}

void main()
{
    vec3 hx = vec3(v_iris01.xz, v_iris2.x), hy = vec3(v_iris01.yw, v_iris2.y);
    vec3 xx = dFdx(hx), xy = dFdy(hx), yx = dFdx(hy), yy = dFdy(hy), rim_x = dFdx(v_rim), rim_y = dFdy(v_rim);
    float turn = fract(v_bulge.x), bend = v_bulge.y * (1.0 - 2.0 * turn);
    int blades = int(u_spectrum.w);
    uncut();
    for (int i = 0; i < max(blades, 1); i++) {
        vec4 b = blades > 0 ? u_blades[i] : vec4(0.0, 0.0, 0.0, 1.0);
        if (b.w > 0.0) {
            vec3 ax = hx + b.x * b.z, ay = hy + b.y * b.z, far = sqrt(ax * ax + ay * ay), inverse = 1.0 / max(far, vec3(1e-20));
            cut_slope(far - b.w, (ax * xx + ay * yx) * inverse, (ax * xy + ay * yy) * inverse, v_iris2.w, v_bulge.z, u_strip.w, u_strip.z > 2.0);
        } else {
            cut_slope(b.x * hx + b.y * hy - b.z, b.x * xx + b.y * yx, b.x * xy + b.y * yy, v_iris2.w, v_bulge.z, u_strip.w, u_strip.z > 2.0);
        }
    }
    cut_slope(v_rim - 1.0 - v_bulge.y * turn * (1.0 - turn), rim_x - bend * dFdx(v_bulge.x), rim_y - bend * dFdy(v_bulge.x), v_iris2.z, v_bulge.w, 0.0, false);
    vec3 open = within();
#ifdef FRINGES
    if (u_strip.z > 0.0) {
        vec3 slope = min(sqrt(0.5 * (xx * xx + xy * xy + yx * yx + yy * yy)), 0.6);
        open *= mask(hx, hy, profile_of(v_iris2.w * slope, v_bulge.z * slope, 0.0));
    }
#endif
    o_color = vec4(lit() * open, 0.0);
}
#endif
