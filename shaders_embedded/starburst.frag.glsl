/* lflare_starburst_at, and the streak beside it. */
out vec4 o_color;
uniform highp sampler2D u_angular; /* distances: angles of all levels of blur, then the mean */
uniform highp sampler2D u_radial;  /* discs: square roots of the flux in them */

flat in vec4 v_irradiance; /* see starburst.vert.glsl */
flat in float v_streak;
in vec2 v_position;

const int ROWS = 168, OCTAVE = 14, BINS = 512, LEVELS = 7, COLUMNS = 1536, SIZES = 15, SAMPLES = 193;
const float PI = 3.14159265, MOST = 30000.0; /* half floats end at 65504 */

vec3 angle_at(float row, float turn, int level)
{
    int first = level == 0 ? 1 : 3 * BINS + 1 - (4 * BINS >> level) + 2 * level, count = level == 0 ? BINS : 2 * BINS >> level; /* lflare__level_first */
    return texture(u_angular, vec2((float(first) + turn * float(count)) / float(COLUMNS), (row + 0.5) / float(ROWS))).rgb;
}

vec3 starburst()
{
    float blur = max(v_irradiance.w / u_burst[0].w, 0.125), q = max(length(v_position) / u_burst[0].w, 1e-3), relative = q / blur;
    float row = clamp(float(OCTAVE) * log2(16.0 * q), 0.0, float(ROWS - 1)), turn = atan(v_position.y, v_position.x) / PI;
    turn -= floor(turn);
    float level = max(1.0 + log2(0.382 * float(BINS) / (PI * relative)), 0.0);
    int l = int(min(level, float(LEVELS - 2)));
    vec3 angle = mix(angle_at(row, turn, l), angle_at(row, turn, l + 1), (exp2(2.0 * min(level - float(l), 1.0)) - 1.0) / 3.0);
    angle = mix(angle, vec3(1.0), clamp(0.5 * (level - float(LEVELS - 1)), 0.0, 1.0));
    vec3 mean = texture(u_angular, vec2(float(COLUMNS - 1) / float(COLUMNS), (row + 0.5) / float(ROWS))).rgb / ((1.0 + q) * (1.0 + q) * (1.0 + q));
    if (row >= float(ROWS - 1)) mean = u_burst[1].rgb / (q * q * q);
    float far = clamp(relative - float(SAMPLES - 1) / 32.0 + 1.0, 0.0, 1.0), size = min(log2(8.0 * blur), float(SIZES - 1));
    vec3 disc = texture(u_radial, vec2((min(32.0 * relative, float(SAMPLES - 1)) + 0.5) / float(SAMPLES), (size + 0.5) / float(SIZES))).rgb;
    return angle * (far * mean * (1.0 + 1.125 * q * q / (relative * relative * (1.0 + q) * (1.0 + q))) + (1.0 - far) * disc * disc / (PI * blur * blur));
}

void main()
{
    vec3 share;
    if (v_streak > 0.0) {
        float along = max(1.0 - abs(v_position.x) / v_streak, 0.0), u = v_position.y / v_irradiance.w, across = max(1.0 - u * u, 0.0);
        share = vec3(1.875 * along * along * along / v_streak * across * across / v_irradiance.w);
    } else {
        share = starburst();
    }
    o_color = vec4(min(v_irradiance.rgb * share, MOST), 0.0);
}
