/* 03_hdr_occlusion: a flare in a scene: the order of calls around HDR, depth, occlusion and tone mapping is in draw_frame. A
   windmill's sails pass before the sun, and the flare fades with what they leave open, measured on the GPU from the scene's
   depth texture. H: half resolution, R: reverse-Z, Escape quits.
   Usage: 03_hdr_occlusion [LENS] [--headless FRAMES OUT.ppm], the last of so many frames at 60 Hz without a window.
   Read 01_one_flare.c first. */

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include "gl_host.h"

static const float fov_y = 0.9f, sun_radius = 0.00465f; /* radians */
static const float sun_direction[3] = {0.35f, 0.2f, -1}; /* this camera never turns: else by the view matrix, to camera space */

typedef struct app {
    lflare *flare;
    lflare_gl *renderer;
    gl_api gl;
    gl_target scene; /* half floats and depth */
    unsigned sky, mill, tone, no_vertices;
    float turn;      /* of the sails */
    int half, reversed;
} app;

/* ---- shaders ---- */

static const char screen_vertex[] =
    "#version 330 core\n"
    "out vec2 place;\n"
    "void main() {\n"
    "    place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;\n"
    "    gl_Position = vec4(place, 0.0, 1.0);\n"
    "}\n";

/* An evening sky; the sun's disc is infinitely far away, so it is part of it. */
static const char sky_fragment[] =
    "#version 330 core\n"
    "in vec2 place;\n"
    "uniform vec3 sun, frame;\n"
    "out vec4 color;\n"
    "void main() {\n"
    "    vec3 way = normalize(vec3(place * frame.xy, -1.0));\n"
    "    float off = length(cross(way, normalize(sun))), edge = 0.5 * fwidth(off);\n"
    "    vec3 light = mix(vec3(0.20, 0.10, 0.05), vec3(0.01, 0.03, 0.09), smoothstep(-0.45, 0.35, way.y));\n"
    "    light += vec3(1.0, 0.6, 0.3) * 0.25 * exp(-9.0 * off);\n"
    "    light += vec3(1.0, 0.9, 0.7) * 200.0 * (1.0 - smoothstep(frame.z - edge, frame.z + edge, off));\n"
    "    color = vec4(light, 1.0);\n"
    "}\n";

/* Four sails and a tower, six vertices each, twelve units ahead. */
static const char mill_vertex[] =
    "#version 330 core\n"
    "const vec2 quad[6] = vec2[6](vec2(-1, 0), vec2(1, 0), vec2(1, 1), vec2(-1, 0), vec2(1, 1), vec2(-1, 1));\n"
    "uniform mat4 projection;\n"
    "uniform float turn;\n"
    "void main() {\n"
    "    int part = gl_VertexID / 6;\n"
    "    vec2 at = quad[gl_VertexID % 6];\n"
    "    float angle = turn + 1.5707963 * float(part);\n"
    "    vec2 sail = mat2(cos(angle), sin(angle), -sin(angle), cos(angle)) * vec2(at.x * mix(0.1, 0.7, at.y), 3.6 * at.y);\n"
    "    vec2 tower = vec2(at.x * mix(0.5, 1.2, at.y), 0.8 - 9.0 * at.y);\n"
    "    gl_Position = projection * vec4(vec3(6.2, 1.0, -12.0) + (part < 4 ? vec3(sail, 0.0) : vec3(tower, -0.5)), 1.0);\n"
    "}\n";

static const char mill_fragment[] =
    "#version 330 core\n"
    "out vec4 color;\n"
    "void main() { color = vec4(0.012, 0.011, 0.014, 1.0); }\n";

/* Rolls highlights off and encodes as sRGB, which the window's framebuffer need not do then. */
static const char tone_fragment[] =
    "#version 330 core\n"
    "uniform sampler2D scene;\n"
    "out vec4 color;\n"
    "void main() {\n"
    "    vec3 light = 1.0 - exp(-texelFetch(scene, ivec2(gl_FragCoord.xy), 0).rgb);\n"
    "    color = vec4(mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, greaterThan(light, vec3(0.0031308))), 1.0);\n"
    "}\n";

/* ---- setting up ---- */

static void open_lens(app *a, const char *path)
{
    lflare_desc desc = {.settings = {.fnumber = 8, .blades = 7, .blade_curvature = 0.2f}};
    lflare_error error;
    char *text;
    if (lflare_file_read(path, NULL, NULL, &text, &desc.text_size, &error) < 0) gl_die(path, error.text);
    desc.text = text;
    if (lflare_create(&desc, &a->flare, &error) < 0) gl_die(path, error.text);
    free(text);
}

/* With a context current. */
static void open_renderer(app *a, lflare_gl_loader load)
{
    lflare_gl_desc desc = {.load = load};
    lflare_error error;
    const char *missing = gl_api_load(&a->gl, load);
    if (missing != NULL) gl_die("GL lacks", missing);
    if (lflare_gl_create(&desc, &a->renderer, &error) < 0) gl_die("GL", error.text);
    a->sky = gl_program(&a->gl, screen_vertex, sky_fragment);
    a->mill = gl_program(&a->gl, mill_vertex, mill_fragment);
    a->tone = gl_program(&a->gl, screen_vertex, tone_fragment);
    if (a->sky == 0 || a->mill == 0 || a->tone == 0) gl_die("GL", "the example's shaders cannot be built");
    a->gl.GenVertexArrays(1, &a->no_vertices);
    a->gl.BindVertexArray(a->no_vertices);
}

static void close_renderer(app *a)
{
    lflare_gl_destroy(a->renderer);
    gl_target_close(&a->gl, &a->scene);
    a->gl.DeleteProgram(a->sky);
    a->gl.DeleteProgram(a->mill);
    a->gl.DeleteProgram(a->tone);
    a->gl.DeleteVertexArrays(1, &a->no_vertices);
}

/* ---- a frame ---- */

/* Column by column. Reverse-Z is a near plane behind the far one; depth then falls with distance. */
static void make_projection(float p[16], float aspect, int reversed)
{
    float from = reversed ? 500 : 0.1f, to = reversed ? 0.1f : 500, scale = 1 / tanf(fov_y / 2);
    memset(p, 0, 16 * sizeof *p);
    p[0] = scale / aspect;
    p[5] = scale;
    p[10] = (to + from) / (from - to);
    p[11] = -1;
    p[14] = 2 * to * from / (from - to);
}

static void draw_scene(app *a, const float projection[16])
{
    const gl_api *gl = &a->gl;
    const float farthest = a->reversed ? 0 : 1;
    gl->ClearBufferfv(GL_DEPTH, 0, &farthest);
    gl->UseProgram(a->sky);
    gl->Uniform3f(gl->GetUniformLocation(a->sky, "sun"), sun_direction[0], sun_direction[1], sun_direction[2]);
    gl->Uniform3f(gl->GetUniformLocation(a->sky, "frame"), 1 / projection[0], 1 / projection[5], sun_radius);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(a->reversed ? GL_GREATER : GL_LESS);
    gl->UseProgram(a->mill);
    gl->UniformMatrix4fv(gl->GetUniformLocation(a->mill, "projection"), 1, 0, projection);
    gl->Uniform1f(gl->GetUniformLocation(a->mill, "turn"), a->turn);
    gl->DrawArrays(GL_TRIANGLES, 0, 30);
    gl->Disable(GL_DEPTH_TEST);
}

/* dt: seconds since the last frame. */
static void draw_frame(app *a, unsigned screen, int width, int height, float dt)
{
    const gl_api *gl = &a->gl;
    lflare_view view = {.width = width, .height = height, .fov_y = fov_y};
    lflare_light sun = {.color = {1, 0.85f, 0.65f}, .angular_radius = sun_radius};
    lflare_gl_depth depth = {.dt = dt, .attack = 0.1f, .release = 0.1f};
    lflare_result result;

    if (a->scene.width != width || a->scene.height != height) {
        gl_target_close(gl, &a->scene);
        if (!gl_target_open(gl, &a->scene, GL_RGBA16F, width, height, 1)) gl_die("GL", "no framebuffer of half floats");
    }
    a->turn += 1.2f * dt;

    /* 1. the scene, into linear HDR and a depth texture */
    make_projection(depth.projection, (float)width / (float)height, a->reversed);
    gl->BindFramebuffer(GL_FRAMEBUFFER, a->scene.framebuffer);
    gl->Viewport(0, 0, width, height);
    draw_scene(a, depth.projection);

    /* 2. lights in camera space and the view become instances, on the CPU */
    memcpy(sun.direction, sun_direction, sizeof sun.direction);
    result = lflare_frame(a->flare, &view, &sun, 1);

    /* 3. how much of the sun the depth leaves open, fading; it stays on the GPU */
    depth.texture = a->scene.depth;
    if (result >= 0) result = lflare_gl_occlusion(a->renderer, &sun, 1, &depth);

    /* 4. the flare, added to the scene */
    if (result >= 0) result = (a->half ? lflare_gl_draw_half : lflare_gl_draw)(a->renderer, lflare_get_tables(a->flare), lflare_get_frame(a->flare));
    if (result >= 0 && a->half) result = lflare_gl_add_half(a->renderer);
    if (result < 0) gl_die("the flare", lflare_result_text(result));

    /* 5. tone mapping, last */
    gl->BindFramebuffer(GL_FRAMEBUFFER, screen);
    gl->UseProgram(a->tone);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_2D, a->scene.color);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

/* ---- with a window, and without ---- */

static void on_key(GLFWwindow *window, int key, int scancode, int action, int mods)
{
    static const char *const titles[2][2] = {{"03_hdr_occlusion", "03_hdr_occlusion, reverse-Z"},
                                             {"03_hdr_occlusion, half", "03_hdr_occlusion, half, reverse-Z"}};
    app *a = (app *)glfwGetWindowUserPointer(window);
    (void)scancode;
    (void)mods;
    if (action != GLFW_PRESS) return;
    if (key == GLFW_KEY_H) a->half = !a->half;
    if (key == GLFW_KEY_R) a->reversed = !a->reversed;
    if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(window, GLFW_TRUE);
    glfwSetWindowTitle(window, titles[a->half][a->reversed]);
}

static void run_window(app *a)
{
    const char *why;
    double before = 0;
    GLFWwindow *window = gl_window_open("03_hdr_occlusion", 1280, 720, GLFW_FALSE, &why);
    if (window == NULL) gl_die("GLFW", why);
    open_renderer(a, glfwGetProcAddress);
    glfwSetWindowUserPointer(window, a);
    glfwSetKeyCallback(window, on_key);
    while (!glfwWindowShouldClose(window)) {
        double now = glfwGetTime();
        int width, height;
        glfwGetFramebufferSize(window, &width, &height);
        if (width > 0 && height > 0) draw_frame(a, 0, width, height, (float)(now - before));
        before = now;
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    close_renderer(a);
    glfwTerminate();
}

static void run_headless(app *a, const char *frames, const char *out)
{
    gl_host host;
    gl_target screen;
    int i, count = atoi(frames);
    if (count < 1) gl_die(frames, "a number of frames was expected");
    if (!gl_host_open(&host, NULL, 0)) gl_die("GL", host.why);
    open_renderer(a, host.load);
    if (!gl_target_open(&a->gl, &screen, GL_RGBA8, 1280, 720, 0)) gl_die("GL", "no framebuffer");
    for (i = 0; i < count; i++) draw_frame(a, screen.framebuffer, screen.width, screen.height, 1 / 60.0f);
    if (!gl_write_ppm(&a->gl, screen.width, screen.height, out)) gl_die(out, "cannot be written");
    close_renderer(a);
    gl_target_close(&a->gl, &screen);
    gl_host_close(&host);
}

int main(int argc, char **argv)
{
    app a = {.turn = 0.3f};
    int headless = argc > 3 && strcmp(argv[argc - 3], "--headless") == 0;
    open_lens(&a, argc > (headless ? 4 : 1) ? argv[1] : "lenses/distagon-25.lens");
    if (headless) run_headless(&a, argv[argc - 2], argv[argc - 1]);
    else run_window(&a);
    lflare_destroy(a.flare);
    return 0;
}
