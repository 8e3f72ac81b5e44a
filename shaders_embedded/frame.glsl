/* What one frame hands to every stage: lflare__gl_frame in lensflare.h has the same layout. */
layout(std140) uniform lflare_frame {
    vec4 u_half;       /* half width, half height of the frame on the sensor; sensor point at its middle */
    vec4 u_lens;       /* mm per pixel, EFL, entrance radius, iris radius */
    vec4 u_spectrum;   /* wavelengths in mm; number of blades */
    vec4 u_strip;      /* lights in the visibility strip, 0 = none counts; gain; the iris has a mask: 1, and 1 with fringes, and 2 dark along the outline; its softness */
    vec4 u_burst[3];   /* starburst: gain, mm of its unit; tail, half thickness of the streak; gain of that, irradiance from which on ghosts have fringes, -1: none has */
    vec4 u_blades[16]; /* normal, distance, arc radius */
    vec4 u_bands;      /* more than three wavelengths: how many, where their colours are in u_ghosts, 0, 0; none: 0 */
    vec4 u_spectral[66]; /* of each: shares of the three in its places, wavelength in mm; what it adds to RGB, 0 */
    vec4 u_lights[928];/* 232 x (slope, axis)(slope length, field angle, angular radius, image x)(image y, irradiance)(place in the strip, -, reach of starburst, of streak) */
};

/* lflare__profile_make at three wavelengths, from softness at each, the middle one's fringes, and what else softens, squared with it;
   waves: fringes' length at each over the middle one's. */
struct Profile {
    vec3 soft, ring, inner, outer;
};

Profile profile_over(vec3 soft, vec3 ring, float softness, vec3 waves)
{
    Profile p;
    p.soft = sqrt(soft * soft + vec3(softness * softness)) + vec3(1e-7);
    p.ring = min(ring * waves, 0.4);
    p.ring *= step(p.soft, 8.0 * p.ring);
    p.inner = p.soft + 5.0 * p.ring;
    p.outer = p.soft + 2.5 * p.ring;
    return p;
}

Profile profile_of(vec3 soft, vec3 ring, float softness) { return profile_over(soft, ring, softness, sqrt(u_spectrum.xyz / u_spectrum.y)); }

/* lflare__profile_dark, told by the fringes' sign */
Profile dark(Profile p)
{
    p.ring = -p.ring;
    p.inner = p.soft;
    return p;
}
