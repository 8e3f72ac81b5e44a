/* One triangle over the whole viewport. */
out vec2 v_place; /* 0 to 1 across it */

void main()
{
    v_place = vec2(float(gl_VertexID & 1) * 2.0, float(gl_VertexID >> 1) * 2.0);
    gl_Position = vec4(2.0 * v_place - 1.0, 0.0, 1.0);
}
