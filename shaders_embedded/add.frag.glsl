/* The half-size picture enlarged, bilinear: its texel i lies between the full picture's pixels 2i and 2i + 1. */
uniform highp sampler2D u_half_picture;
uniform vec3 u_enlarge; /* the full picture's size in those of the half picture; gain */

in vec2 v_place;
out vec4 o_color;

void main() { o_color = vec4(texture(u_half_picture, v_place * u_enlarge.xy).rgb * u_enlarge.z, 0.0); }
