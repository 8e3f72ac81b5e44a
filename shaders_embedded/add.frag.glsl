/* The half-size picture enlarged: bilinear, with texel i between the full picture's pixels 2i and 2i + 1. */
uniform highp sampler2D u_half_picture;
uniform vec3 u_enlarge; /* full picture's size in the half picture's texels; gain */

in vec2 v_place;
out vec4 o_color;

void main()
{
    vec2 place = v_place * u_enlarge.xy - 0.5, corner = floor(place), f = place - corner;
    ivec2 last = textureSize(u_half_picture, 0) - 1, a = clamp(ivec2(corner), ivec2(0), last), b = min(ivec2(corner) + 1, last);
    vec3 low = mix(texelFetch(u_half_picture, a, 0).rgb, texelFetch(u_half_picture, ivec2(b.x, a.y), 0).rgb, f.x);
    vec3 high = mix(texelFetch(u_half_picture, ivec2(a.x, b.y), 0).rgb, texelFetch(u_half_picture, b, 0).rgb, f.x);
    o_color = vec4(mix(low, high, f.y) * u_enlarge.z, 0.0);
}
