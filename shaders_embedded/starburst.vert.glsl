/* Two rectangles a light: its starburst, its streak. */
uniform highp usampler2D u_visibility;

flat out vec4 v_irradiance; /* times the gain of either; what its lamp and a pixel blur it by, mm */
flat out float v_streak;    /* half its length; 0: the starburst */
out vec2 v_position;        /* from the light's image on the sensor, mm */

void main()
{
    int light = (gl_InstanceID >> 1) * 4;
    vec4 l1 = u_lights[light + 1], l2 = u_lights[light + 2], l3 = u_lights[light + 3];
    vec2 image = vec2(l1.w, l2.x), corner = 2.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0, reach = l3.zz;
    vec3 irradiance = l2.yzw * u_strip.y;
    int place = int(l3.x);
    float lamp = u_lens.y * l1.z;
    if (place < int(u_strip.x)) irradiance *= uintBitsToFloat(texelFetch(u_visibility, ivec2(place, 0), 0).r);
    v_irradiance = vec4(irradiance * u_burst[0].rgb, sqrt(lamp * lamp + 0.318 * u_lens.x * u_lens.x));
    v_streak = 0.0;
    if ((gl_InstanceID & 1) != 0) {
        float half_width = sqrt(u_burst[1].w * u_burst[1].w + 7.0 * (0.715 * 0.715 / 5.0 * u_lens.x * u_lens.x + 0.25 * lamp * lamp));
        reach = vec2(l3.w, l3.w > 0.0 ? half_width : 0.0);
        v_irradiance = vec4(irradiance * u_burst[2].rgb, half_width);
        v_streak = l3.w;
    }
    v_position = corner * reach;
    gl_Position = vec4(-(image + v_position - u_half.zw) / u_half.xy, 0.0, 1.0);
    if (!(reach.x > 0.0) || !(irradiance.x + irradiance.y + irradiance.z > 0.0)) gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
}
