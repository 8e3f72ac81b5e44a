/* make bench, after bench.c: what the room "gl" costs. First the CPU alone, against functions that do nothing; then, where a
   context can be had without a window, milliseconds a frame beside a plain fill of as many pixels, the half-size picture, the
   fragments shaded against those that add light, and the polynomial and the traced model beside the paraxial one. */
#define _POSIX_C_SOURCE 200809L
#define GL_GLEXT_PROTOTYPES
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include <GL/gl.h>
#include <GL/glext.h>
#include "bench.h"
#include <EGL/egl.h>
#include "examples/gl_host.h"

enum { W = 1280, H = 720, FRAMES = 15 };

static lflare_gl *create_gl(lflare_gl_loader load, int no_restore, uint32_t models)
{
    static char log[4096];
    lflare_gl_desc desc = {0};
    lflare_gl *gl = NULL;
    lflare_error error;
    desc.load = load;
    desc.no_restore = no_restore;
    desc.models = models;
    desc.log = log;
    desc.log_size = sizeof log;
    if (lflare_gl_create(&desc, &gl, &error) < 0) {
        printf("%s\n%s\n", error.text, log);
        exit(2);
    }
    return gl;
}

/* ---- the CPU's share: a GL that does nothing ---- */

static long calls, uploaded;

/* Called with whatever arguments a function has, which the calling conventions of PCs and ARM allow: one for all. */
static int stub(void)
{
    calls++;
    return 0;
}

static const GLubyte *stub_string(GLenum name) { (void)name; return (const GLubyte *)"3.3.0 stub"; }
static GLenum stub_complete(GLenum where) { (void)where; return GL_FRAMEBUFFER_COMPLETE; }
static void stub_done(GLuint object, GLenum what, GLint *out) { (void)object; (void)what; *out = 1; }

static void stub_names(GLsizei count, GLuint *out)
{
    static GLuint next = 1;
    while (count-- > 0) *out++ = next++;
}

static void stub_data(GLenum target, GLsizeiptr size, const void *data, GLenum usage)
{
    (void)target;
    (void)usage;
    calls++;
    if (data != NULL) uploaded += size;
}

static void stub_part(GLenum target, GLintptr at, GLsizeiptr size, const void *data)
{
    (void)target;
    (void)at;
    (void)data;
    calls++;
    uploaded += size;
}

static void stub_image(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height, GLint border, GLenum format, GLenum type, const void *data)
{
    (void)target, (void)level, (void)border, (void)format, (void)type;
    calls++;
    if (data != NULL) uploaded += (long)width * height * (internal == GL_RGBA32F ? 16 : 4);
}

static lflare_gl_function load_stub(const char *name)
{
    if (strncmp(name, "glGen", 5) == 0) return (lflare_gl_function)stub_names;
    if (strcmp(name, "glGetString") == 0) return (lflare_gl_function)stub_string;
    if (strcmp(name, "glGetShaderiv") == 0 || strcmp(name, "glGetProgramiv") == 0) return (lflare_gl_function)stub_done;
    if (strcmp(name, "glCheckFramebufferStatus") == 0) return (lflare_gl_function)stub_complete;
    if (strcmp(name, "glBufferData") == 0) return (lflare_gl_function)stub_data;
    if (strcmp(name, "glBufferSubData") == 0) return (lflare_gl_function)stub_part;
    if (strcmp(name, "glTexImage2D") == 0) return (lflare_gl_function)stub_image;
    return (lflare_gl_function)stub;
}

static lflare_gl_depth some_depth(void)
{
    lflare_gl_depth depth = {0};
    depth.texture = 1;
    depth.projection[0] = 1;
    depth.projection[5] = 16.0f / 9;
    depth.projection[10] = depth.projection[11] = -1;
    depth.projection[14] = -0.1f;
    depth.dt = 0.016f;
    depth.attack = depth.release = 0.1f;
    return depth;
}

static const char *name_of(const lflare *flare)
{
    const lflare_lens *lens = lflare_get_lens(flare);
    return lens != NULL ? lens->prescription.name : "";
}

static void bench_cpu(const char *path, int no_restore)
{
    enum { REPEAT = 100 };
    lflare_settings settings = ghosts_alone();
    lflare *flare = open_lens(path, &settings, NULL);
    lflare_gl *gl = create_gl(load_stub, no_restore, 0);
    lflare_gl_depth depth = some_depth();
    lflare_view view = {0};
    lflare_light lights[16];
    const char *name = name_of(flare), *how = no_restore ? "no restore" : "restore";
    int count, frame = 0, i;
    double t, occlusion;
    view.width = W;
    view.height = H;
    for (count = 1; count <= 16; count += 15) {
        int32_t most = 0;
        move_lights(lights, count, frame);
        lflare_frame(flare, &view, lights, count);
        uploaded = 0;
        lflare_gl_draw(gl, lflare_get_tables(flare), lflare_get_frame(flare));
        if (count == 1) printf("gl on the CPU, %s, %s: first draw uploads %ld bytes\n", name, how, uploaded);
        calls = uploaded = 0;
        MEDIAN(t, {
            for (i = 0; i < REPEAT; i++) {
                move_lights(lights, count, frame++);
                lflare_frame(flare, &view, lights, count);
                lflare_gl_draw(gl, lflare_get_tables(flare), lflare_get_frame(flare));
                if (lflare_get_frame(flare)->instance_count > most) most = lflare_get_frame(flare)->instance_count;
            }
        });
        printf("  frame and draw, %2d light%s  %9.3f us   %ld bytes, %ld calls, at most %d instances   (aim for the Canon: %d us)\n", count,
               count == 1 ? " " : "s", 1e6 * t / REPEAT, uploaded / (RUNS * REPEAT), calls / (RUNS * REPEAT), (int)most, count == 1 ? 15 : 100);
        calls = uploaded = 0;
        MEDIAN(occlusion, for (i = 0; i < REPEAT; i++) lflare_gl_occlusion(gl, lights, count, &depth));
        printf("  occlusion, %2d light%s       %9.3f us   %ld bytes, %ld calls\n", count, count == 1 ? " " : "s", 1e6 * occlusion / REPEAT,
               uploaded / (RUNS * REPEAT), calls / (RUNS * REPEAT));
    }
    lflare_gl_destroy(gl);
    lflare_destroy(flare);
}

/* ---- a real context ---- */

static lflare_gl_function load(const char *name) { return (lflare_gl_function)eglGetProcAddress(name); }

/* Puts a main of our own around the ghosts' fragment shaders, which throws away what adds no light. */
static void lit_source(GLuint shader, GLsizei count, const GLchar *const *pieces, const GLint *lengths)
{
    const GLchar *all[32];
    GLint kind = 0;
    int i, n = 0, ghost = count < 30 && strstr(pieces[2], "lflare_frame") != NULL;
    glGetShaderiv(shader, GL_SHADER_TYPE, &kind);
    if (kind != GL_FRAGMENT_SHADER || !ghost) {
        glShaderSource(shader, count, pieces, lengths);
        return;
    }
    for (i = 0; i < count; i++) {
        if (i == 2) all[n++] = "#define main flare_main\n"; /* after version and program */
        all[n++] = pieces[i];
    }
    all[n++] = "#undef main\nvoid main() { flare_main(); if (max(o_color.r, max(o_color.g, o_color.b)) <= 0.0) discard; }\n";
    glShaderSource(shader, n, all, NULL);
}

static lflare_gl_function load_lit(const char *name)
{
    return strcmp(name, "glShaderSource") == 0 ? (lflare_gl_function)lit_source : load(name);
}

static int target_width, target_height;

static void open_target(GLint format, int width, int height)
{
    GLuint texture, framebuffer;
    target_width = width;
    target_height = height;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, GL_RGBA, GL_FLOAT, NULL);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) exit(2);
    glViewport(0, 0, width, height);
}

static GLuint shader_of(GLenum kind, const char *text)
{
    GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &text, NULL);
    glCompileShader(shader);
    return shader;
}

/* One triangle over the viewport, one constant. */
static GLuint fill_program(void)
{
    GLuint program = glCreateProgram();
    glAttachShader(program, shader_of(GL_VERTEX_SHADER, "#version 330 core\nvoid main() {\n"
                                                        "gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }\n"));
    glAttachShader(program, shader_of(GL_FRAGMENT_SHADER, "#version 330 core\nout vec4 colour;\nvoid main() { colour = vec4(0.01, 0.02, 0.03, 0.0); }\n"));
    glLinkProgram(program);
    return program;
}

/* The limit: whole rectangles and a part of one, `fragments` in all. */
static void fill(GLuint program, double fragments)
{
    double rows = fragments / target_width;
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    glUseProgram(program);
    for (; rows >= 1; rows -= target_height) {
        glViewport(0, 0, target_width, rows >= target_height ? target_height : (GLsizei)rows);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glViewport(0, 0, target_width, target_height);
}

/* Work for the GPU, one of three kinds. */
typedef struct job {
    lflare_gl *gl; /* NULL: the plain fill */
    const lflare *flare;
    int half;
    GLuint program;
    double fragments;
} job;

static void draw(const job *j)
{
    if (j->gl == NULL) {
        fill(j->program, j->fragments);
    } else if (j->half) {
        lflare_gl_draw_half(j->gl, lflare_get_tables(j->flare), lflare_get_frame(j->flare));
        lflare_gl_add_half(j->gl);
    } else {
        lflare_gl_draw(j->gl, lflare_get_tables(j->flare), lflare_get_frame(j->flare));
    }
}

static double counted(const job *j, GLenum what)
{
    GLuint query;
    GLuint64 result = 0;
    glGenQueries(1, &query);
    glBeginQuery(what, query);
    draw(j);
    glEndQuery(what);
    glGetQueryObjectui64v(query, GL_QUERY_RESULT, &result);
    glDeleteQueries(1, &query);
    return (double)result;
}

static double milliseconds(const job *j)
{
    double start = now();
    draw(j);
    glFinish();
    return 1e3 * (now() - start);
}

/* The GPU's own clock; llvmpipe answers too, though it has none. 0 = there is none. */
static int has_gpu_clock(void)
{
    GLint bits = 0;
    glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &bits);
    return bits > 0 && strstr((const char *)glGetString(GL_RENDERER), "llvmpipe") == NULL;
}

static void picture(const job *j, float *pixels)
{
    glClear(GL_COLOR_BUFFER_BIT);
    draw(j);
    glReadPixels(0, 0, W, H, GL_RGBA, GL_FLOAT, pixels);
}

/* PSNR over lit pixels, linear; white: the 99.8th percentile of them. */
static double psnr(const float *a, const float *b)
{
    static double most[W * H];
    double sum = 0, white;
    size_t i, lit = 0, count = 0;
    int k;
    for (i = 0; i < (size_t)W * H; i++) {
        double m = (double)fmaxf(b[4 * i], fmaxf(b[4 * i + 1], b[4 * i + 2]));
        if (m > 0) most[lit++] = m;
    }
    if (lit == 0) return 0;
    qsort(most, lit, sizeof most[0], by_value);
    white = most[(size_t)((double)(lit - 1) * 0.998)];
    for (i = 0; i < (size_t)W * H; i++) {
        double error = 0, m = 0;
        for (k = 0; k < 3; k++) {
            double x = (double)a[4 * i + (size_t)k] / white, y = (double)b[4 * i + (size_t)k] / white, d = fmin(x, 1) - fmin(y, 1);
            m = fmax(m, fmax(x, y));
            error += d * d;
        }
        if (m <= 1e-4) continue;
        sum += error;
        count += 3;
    }
    return sum > 0 ? -10 * log10(sum / (double)count) : 999;
}

static lflare *frame_of(const char *path, double fnumber, int blades, float radius)
{
    lflare_settings settings = ghosts_alone();
    lflare_view view = {0};
    lflare_light light = {{0.0954f, 0, -1}, {1, 1, 1}, {0}, 0, 0, 0}; /* 5.45 degrees */
    lflare *flare;
    settings.fnumber = fnumber;
    settings.blades = blades;
    flare = open_lens(path, &settings, NULL);
    view.width = W;
    view.height = H;
    light.angular_radius = radius;
    lflare_frame(flare, &view, &light, 1);
    return flare;
}

/* Medians of jobs that take turns, so that whatever else the machine does meets them all alike. */
static void take_turns(const job *jobs, double *ms, double *gpu)
{
    double times[4][FRAMES];
    int clock = has_gpu_clock(), i, k;
    for (i = 0; i < 4; i++) draw(&jobs[i]); /* uploads, and whatever is compiled on first use */
    glFinish();
    for (k = 0; k < FRAMES; k++)
        for (i = 0; i < 4; i++) times[i][k] = milliseconds(&jobs[i]);
    for (i = 0; i < 4; i++) {
        qsort(times[i], FRAMES, sizeof times[i][0], by_value);
        ms[i] = times[i][FRAMES / 2];
        gpu[i] = clock ? 1e-6 * counted(&jobs[i], GL_TIME_ELAPSED) : 0;
    }
}

static void bench_time(lflare_gl *gl, GLuint program, const char *path, double fnumber)
{
    static float full[4 * W * H], half[4 * W * H];
    lflare *flare = frame_of(path, fnumber, 0, 0);
    job jobs[4]; /* whole, its limit, half, its limit */
    double ms[4], gpu[4];
    int i;
    memset(jobs, 0, sizeof jobs);
    for (i = 0; i < 4; i += 2) {
        jobs[i].gl = gl;
        jobs[i].flare = flare;
        jobs[i].half = i == 2;
        jobs[i + 1].program = program;
        jobs[i + 1].fragments = counted(&jobs[i], GL_SAMPLES_PASSED);
    }
    take_turns(jobs, ms, gpu);
    printf("gl, %s, f/%g, light 5.45 degrees off, %d ghosts\n", name_of(flare), fnumber, (int)lflare_get_frame(flare)->instance_count);
    for (i = 0; i < 4; i += 2) {
        printf("  %s  %8.2f ms; plain fill of as many fragments (%6.2f million) %8.2f ms; ratio %.2f", i == 0 ? "whole" : "half ", ms[i],
               1e-6 * jobs[i + 1].fragments, ms[i + 1], ms[i] / ms[i + 1]);
        if (gpu[i] > 0) printf("; the GPU's clock: %.3f and %.3f ms, ratio %.2f", gpu[i], gpu[i + 1], gpu[i] / gpu[i + 1]);
        printf("\n");
    }
    picture(&jobs[0], full);
    picture(&jobs[2], half);
    printf("  half costs %.2f of whole and differs by %.1f dB\n", ms[2] / ms[0], psnr(half, full));
    lflare_destroy(flare);
}

/* A ghost's geometry is to lie close around its light. */
static void bench_fill(lflare_gl *plain, lflare_gl *throwing, const char *path, double fnumber)
{
    int variant;
    for (variant = 0; variant < 4; variant++) {
        float radius = variant >= 2 ? 0.00465f : 0;
        lflare *flare = frame_of(path, fnumber, variant % 2 != 0 ? 6 : 0, radius);
        job j = {0};
        double shaded, lit;
        j.flare = flare;
        j.gl = plain;
        shaded = counted(&j, GL_SAMPLES_PASSED);
        j.gl = throwing;
        lit = counted(&j, GL_SAMPLES_PASSED);
        printf("fill, %s, f/%g, %s, lamp %4g mrad: %7.3f million fragments shaded, %7.3f lit; ratio %.3f (aim 1.15)\n",
               name_of(flare), fnumber, variant % 2 != 0 ? "6 blades  " : "round iris", 1e3 * (double)radius, 1e-6 * shaded, 1e-6 * lit,
               shaded / lit);
        lflare_destroy(flare);
    }
}

/* Milliseconds a frame of each model, one light that moves every frame; they take turns. */
static void frames_of(lflare_gl *gl, lflare *const *flares, double *ms)
{
    double times[2][FRAMES];
    lflare_view view = {0};
    lflare_light light;
    job jobs[2];
    int i, k;
    memset(jobs, 0, sizeof jobs);
    view.width = W;
    view.height = H;
    for (k = -1; k < FRAMES; k++) /* the first one uploads */
        for (i = 0; i < 2; i++) {
            double start = now();
            move_lights(&light, 1, k + 1);
            lflare_frame(flares[i], &view, &light, 1);
            jobs[i].gl = gl;
            jobs[i].flare = flares[i];
            draw(&jobs[i]);
            glFinish();
            if (k >= 0) times[i][k] = 1e3 * (now() - start);
        }
    for (i = 0; i < 2; i++) {
        qsort(times[i], FRAMES, sizeof times[i][0], by_value);
        ms[i] = times[i][FRAMES / 2];
    }
}

/* The polynomial and the traced model beside the paraxial one, lens wide open, iris round. */
static void bench_models(lflare_gl *gl, const char *path)
{
    static const char *const names[3] = {"paraxial  ", "polynomial", "traced    "};
    lflare_settings settings = ghosts_alone(), exact = settings;
    lflare *flares[3], *pair[2];
    double seconds, ms[3], again[2], began;
    size_t size;
    void *fit;
    int i, clock = has_gpu_clock();
    flares[0] = open_lens(path, &settings, NULL);
    fit = fit_of(flares[0], &size, &seconds);
    flares[1] = open_fitted(path, &settings, NULL, fit, size);
    exact.model = LFLARE_MODEL_TRACED;
    began = now();
    flares[2] = open_lens(path, &exact, NULL);
    seconds = now() - began;
    frames_of(gl, flares, ms);
    pair[0] = flares[0];
    pair[1] = flares[2];
    frames_of(gl, pair, again);
    ms[2] = again[1] * ms[0] / again[0];
    printf("gl, %s, f/%g, the light moves\n", name_of(flares[0]), (double)lflare_get_tables(flares[0])->fnumber);
    for (i = 0; i < 3; i++) {
        job j = {0};
        int32_t count = lflare_get_frame(flares[i])->instance_count;
        int32_t each = i == 0 ? LFLARE__GL_INSIDE + LFLARE__GL_RING : LFLARE_PATCH_DIRECTIONS * (LFLARE_PATCH_RINGS + LFLARE_PATCH_BANDS); /* by indices, each once */
        j.gl = gl;
        j.flare = flares[i];
        printf("  %s %8.2f ms; %d instances, %d vertices, %.2f million fragments", names[i], ms[i], (int)count, (int)(count * each),
               1e-6 * counted(&j, GL_SAMPLES_PASSED));
        if (clock) printf("; the GPU's clock: %.3f ms", 1e-6 * counted(&j, GL_TIME_ELAPSED));
        printf("\n");
    }
    printf("  ratios %.2f, %.2f (aim for traced: 4); outlines of traced ghosts in %.2f s (aim: 1)\n", ms[1] / ms[0], ms[2] / ms[0], seconds);
    for (i = 0; i < 3; i++) lflare_destroy(flares[i]);
    free(fit);
}

static double light_in(const float *pixels)
{
    double sum = 0;
    size_t i;
    for (i = 0; i < (size_t)4 * W * H; i++) sum += i % 4 != 3 ? (double)pixels[i] : 0;
    return sum;
}

/* One frame within budgets (0 = none): milliseconds, light, what is drawn. Budgets are read by frames alone, so tables need not be made anew. */
static double within_budget(lflare_gl *gl, const lflare *flare, int32_t ghosts, int32_t vertices, int32_t pixels, double *light, double *fragments, int32_t *instances)
{
    static float picture_of[4 * W * H];
    lflare_tables t = *lflare_get_tables(flare);
    lflare_frame_data f = *lflare_get_frame(flare);
    lflare_view view = {0};
    lflare_light lamp = {{0.0954f, 0, -1}, {1, 1, 1}, {0}, 0, 0, 0};
    GLuint query, passed = 0;
    double times[FRAMES];
    int k;
    view.width = W;
    view.height = H;
    t.ghost_budget = ghosts;
    t.vertex_budget = vertices;
    t.pixel_budget = pixels;
    lflare_frame_build(&t, &view, &lamp, 1, &f);
    glGenQueries(1, &query);
    glBeginQuery(GL_SAMPLES_PASSED, query);
    glClear(GL_COLOR_BUFFER_BIT);
    lflare_gl_draw(gl, &t, &f);
    glEndQuery(GL_SAMPLES_PASSED);
    glGetQueryObjectuiv(query, GL_QUERY_RESULT, &passed);
    glDeleteQueries(1, &query);
    glReadPixels(0, 0, W, H, GL_RGBA, GL_FLOAT, picture_of);
    *light = light_in(picture_of);
    *fragments = (double)passed;
    *instances = f.instance_count;
    for (k = 0; k < 5; k++) {
        double start = now();
        lflare_gl_draw(gl, &t, &f);
        glFinish();
        times[k] = 1e3 * (now() - start);
    }
    qsort(times, 5, sizeof times[0], by_value);
    return times[2];
}

static int32_t ghosts_in(const lflare_frame_data *f)
{
    int32_t i, count = 0;
    for (i = 0; i < f->instance_count; i++) count += i == 0 || f->instances[i].ghost != f->instances[i - 1].ghost;
    return count;
}

/* What budgets give, wide open: the weakest fifth of the ghosts left out, half the vertices, half the fragments. */
static void bench_budgets(lflare_gl *gl, const char *path, int traced)
{
    static const char *const names[4] = {"everything", "without the weakest fifth", "half the vertices", "half the fragments"};
    lflare_settings settings = ghosts_alone();
    lflare_view view = {0};
    lflare_light lamp = {{0.0954f, 0, -1}, {1, 1, 1}, {0}, 0, 0, 0};
    double ms[4], light[4], fragments[4];
    int32_t instances[4], each = traced ? LFLARE_PATCH_DIRECTIONS * (LFLARE_PATCH_RINGS + LFLARE_PATCH_BANDS) : LFLARE__GL_INSIDE + LFLARE__GL_RING, ghosts;
    lflare *flare;
    int i;
    settings.model = traced ? LFLARE_MODEL_TRACED : LFLARE_MODEL_PARAXIAL;
    flare = open_lens(path, &settings, NULL);
    view.width = W;
    view.height = H;
    lflare_frame(flare, &view, &lamp, 1);
    ghosts = ghosts_in(lflare_get_frame(flare));
    printf("gl, %s, %s, budgets, %d ghosts in the frame\n", name_of(flare), traced ? "traced" : "paraxial", (int)ghosts);
    for (i = 0; i < 4; i++) {
        ms[i] = within_budget(gl, flare, i == 1 ? ghosts - ghosts / 5 : 0, i == 2 ? instances[0] * each / 2 : 0, i == 3 ? (int32_t)(fragments[0] / 2) : 0, &light[i], &fragments[i], &instances[i]);
        printf("  %-25s %8.2f ms (%.2f of it), %7d vertices (%.3f), %6.2f million fragments (%.3f), light %.4f\n", names[i], ms[i], ms[i] / ms[0], (int)(instances[i] * each),
               (double)instances[i] / instances[0], 1e-6 * fragments[i], fragments[i] / fragments[0], light[i] / light[0]);
    }
    lflare_destroy(flare);
}

/* What fringes and starbursts cost beside ghosts with plain edges. */
static void bench_diffraction(lflare_gl *gl, const char *path, double fnumber)
{
    static const char *const names[2] = {"with fringes", "whole flare "};
    lflare_settings settings = ghosts_alone();
    double ms[2];
    int i;
    settings.fnumber = fnumber;
    for (i = 0; i < 2; i++) {
        lflare_settings more = settings;
        lflare *flares[2];
        more.no_ringing = 0;
        more.no_starburst = i == 0;
        flares[0] = open_lens(path, &settings, NULL);
        flares[1] = open_lens(path, &more, NULL);
        frames_of(gl, flares, ms);
        printf("gl, %s, f/%g, %s %8.2f ms, plain ghosts %8.2f ms; ratio %.2f (aim for fringes: 1.3)\n", name_of(flares[0]), fnumber, names[i], ms[1], ms[0], ms[1] / ms[0]);
        lflare_destroy(flares[0]);
        lflare_destroy(flares[1]);
    }
}

/* ---- a game's frame ---- */

enum { WIDE = 1920, HIGH = 1080, GAME_FRAMES = 100 };

/* Microseconds of a frame whose lights move: the CPU's for building it and for handing it to GL; the GPU's own; the GPU's into a
   viewport of a few pixels, which leaves the vertices' work; and per frame where frames follow each other without waiting, as in a game. */
typedef struct game_frame {
    double build, submit, gpu, vertices, wall;
} game_frame;

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof values[0], by_value);
    return values[count / 2];
}

static void next_game_frame(lflare_gl *gl, lflare *flare, int lights, int k, GLuint query, double *build, double *submit)
{
    lflare_view view = {0};
    lflare_light light[16];
    double start = now(), built;
    view.width = WIDE;
    view.height = HIGH;
    move_lights(light, lights, k);
    lflare_frame(flare, &view, light, lights);
    built = now();
    if (query != 0) glBeginQuery(GL_TIME_ELAPSED, query);
    lflare_gl_draw(gl, lflare_get_tables(flare), lflare_get_frame(flare));
    *build = built - start;
    *submit = now() - built;
    if (query != 0) glEndQuery(GL_TIME_ELAPSED);
    glFlush();
}

/* Median of the GPU's microseconds, at most 100 frames or about a third of a second. */
static double gpu_time(lflare_gl *gl, lflare *flare, int lights, double *build, double *submit)
{
    static double builds[GAME_FRAMES], submits[GAME_FRAMES], gpu[GAME_FRAMES];
    static GLuint queries[GAME_FRAMES];
    double began;
    int n = 0;
    glGenQueries(GAME_FRAMES, queries);
    for (began = now(); now() - began < 0.1 || n == 0; n++) { /* an idle GPU's clock is slow */
        next_game_frame(gl, flare, lights, 0, 0, build, submit);
        glFinish();
    }
    n = 0;
    began = now();
    for (; n < GAME_FRAMES && (n < 3 || now() - began < 0.3); n++) {
        GLuint elapsed = 0;
        next_game_frame(gl, flare, lights, n, queries[n], &builds[n], &submits[n]);
        if (n < 2) continue;
        glGetQueryObjectuiv(queries[n - 2], GL_QUERY_RESULT, &elapsed); /* two frames behind, so that nothing piles up */
        gpu[n - 2] = 1e-3 * elapsed;
    }
    glDeleteQueries(GAME_FRAMES, queries);
    *build = 1e6 * median(builds, n);
    *submit = 1e6 * median(submits, n);
    return median(gpu, n - 2);
}

static game_frame game_frame_of(lflare_gl *gl, lflare *flare, int lights)
{
    game_frame out;
    double began, unused[2];
    int k;
    glViewport(0, 0, 16, 9);
    out.vertices = gpu_time(gl, flare, lights, &unused[0], &unused[1]);
    glViewport(0, 0, WIDE, HIGH);
    out.gpu = gpu_time(gl, flare, lights, &out.build, &out.submit);
    began = now();
    for (k = 0; k < GAME_FRAMES && (k < 3 || now() - began < 0.3); k++) next_game_frame(gl, flare, lights, k, 0, &unused[0], &unused[1]);
    glFinish();
    out.wall = 1e6 * (now() - began) / k;
    return out;
}

/* Milliseconds of the first draw after a configure, its uploads done. */
static double first_draw(lflare_gl *gl, lflare *flare)
{
    double began, unused[2];
    glFinish();
    began = now();
    next_game_frame(gl, flare, 1, 0, 0, &unused[0], &unused[1]);
    glFinish();
    return 1e3 * (now() - began);
}

/* All models, ghosts alone and whole flares. Only on a GPU: llvmpipe would take minutes. */
static void bench_game(lflare_gl *gl, GLuint program, const char *path, double fnumber)
{
    static const char *const names[3] = {"paraxial  ", "polynomial", "traced    "};
    lflare_settings plain = ghosts_alone();
    lflare *flare = open_lens(path, &plain, NULL);
    double seconds, paraxial[4] = {0};
    size_t size;
    void *fit = fit_of(flare, &size, &seconds);
    int model, whole;
    printf("game, %s, f/%g, %d x %d, RGBA16F; microseconds\n", name_of(flare), fnumber, WIDE, HIGH);
    lflare_destroy(flare);
    for (model = 0; model < 3; model++)
        for (whole = 0; whole < 2; whole++) {
            lflare_settings settings = plain;
            double first, again;
            int lights;
            settings.fnumber = fnumber;
            settings.no_ringing = settings.no_starburst = !whole;
            settings.model = model == 0 ? LFLARE_MODEL_PARAXIAL : model == 1 ? LFLARE_MODEL_POLYNOMIAL : LFLARE_MODEL_TRACED;
            flare = open_fitted(path, &settings, NULL, fit, size);
            first = first_draw(gl, flare);
            settings.fnumber = 1.2 * (double)lflare_get_tables(flare)->fnumber;
            if (lflare_configure(flare, &settings, NULL) < 0) exit(2);
            again = first_draw(gl, flare);
            settings.fnumber = fnumber;
            if (lflare_configure(flare, &settings, NULL) < 0) exit(2);
            for (lights = 1; lights <= (fnumber > 0 ? 16 : 1); lights += 15) { /* sixteen lights wide open: seconds a frame */
                game_frame f = game_frame_of(gl, flare, lights);
                double *base = &paraxial[2 * whole + lights / 16], filled;
                job j = {0}, limit = {0};
                j.gl = gl;
                j.flare = flare;
                limit.program = program;
                limit.fragments = counted(&j, GL_SAMPLES_PASSED);
                filled = limit.fragments > 0 ? 1e-3 * counted(&limit, GL_TIME_ELAPSED) : 0; /* some GPUs lose the count of the longest frames */
                if (model == 0) *base = f.gpu;
                printf("  %s %s %2d light%s  CPU: frame %7.2f, draw %7.2f; GPU %9.1f (%5.2f of paraxial), vertices alone %8.1f, plain fill of %7.2f million fragments %9.1f;"
                       " frame after frame %9.1f; %6d instances", names[model], whole ? "whole " : "ghosts", lights, lights == 1 ? " " : "s", f.build, f.submit, f.gpu,
                       f.gpu / *base, f.vertices, 1e-6 * limit.fragments, filled, f.wall, (int)lflare_get_frame(flare)->instance_count);
                if (lights == 1) printf("; first draw %.2f ms, after a change of the iris %.2f ms", first, again);
                printf("\n");
            }
            lflare_destroy(flare);
        }
    free(fit);
}

/* What the target's format costs; the half-size picture. */
static void bench_targets(lflare_gl *gl, const char *path)
{
    static const struct {
        GLint format;
        const char *name;
    } targets[4] = {{GL_RGBA32F, "RGBA32F"}, {GL_R11F_G11F_B10F, "R11F_G11F_B10F"}, {GL_RGBA8, "RGBA8"}, {GL_RGBA16F, "RGBA16F"}};
    lflare_settings settings = {0};
    lflare *flare;
    double unused[2];
    job half = {0};
    int i;
    settings.fnumber = 8;
    flare = open_lens(path, &settings, NULL);
    printf("game, %s, f/8, paraxial, whole flare, one light, GPU microseconds:", name_of(flare));
    for (i = 0; i < 4; i++) {
        open_target(targets[i].format, WIDE, HIGH);
        printf(" %s %.1f,", targets[i].name, gpu_time(gl, flare, 1, &unused[0], &unused[1]));
    }
    half.gl = gl;
    half.flare = flare;
    half.half = 1;
    draw(&half);
    printf(" half %.1f\n", 1e-3 * counted(&half, GL_TIME_ELAPSED));
    lflare_destroy(flare);
}

/* Small frames beside plain fills, by the clock on the wall. */
static void bench_parts(lflare_gl *gl, lflare_gl *throwing, GLuint program)
{
    static const struct {
        const char *path;
        double fnumber;
    } frames[3] = {{"lenses/heliar-tronnier.lens", 22}, {"lenses/nikon-80-200-mid.lens", 2.8}, {"lenses/nikon-80-200-mid.lens", 8}};
    int i;
    for (i = 0; i < 3; i++) bench_time(gl, program, frames[i].path, frames[i].fnumber);
    for (i = 0; i < 3; i++) bench_fill(gl, throwing, frames[i].path, frames[i].fnumber);
    bench_diffraction(gl, "lenses/heliar-tronnier.lens", 8);
    bench_diffraction(gl, "lenses/nikon-80-200-mid.lens", 8);
    bench_diffraction(gl, "lenses/nikon-80-200-mid.lens", 2.8);
    bench_models(gl, "lenses/heliar-tronnier.lens");
    bench_models(gl, "lenses/nikon-80-200-mid.lens");
    for (i = 0; i < 4; i++) bench_budgets(gl, i < 2 ? "lenses/heliar-tronnier.lens" : "lenses/nikon-80-200-mid.lens", i % 2);
}

static void bench_gpu(int game)
{
    static const char *const compiled[4] = {"the paraxial model", "the polynomial model", "the traced model", "all models"};
    const char *which = getenv("GL_HOST") != NULL && strcmp(getenv("GL_HOST"), "gpu") == 0 ? "gpu" : "egl";
    gl_host context;
    lflare_gl *gl = NULL, *throwing;
    GLuint program, array;
    double began;
    int i;
    if (!gl_host_open(&context, which, 0)) {
        printf("gl: no GL 3.3 without a window here, so nothing is measured on it\n");
        gl_host_close(&context);
        return;
    }
    printf("gl: %s, %s; %d x %d, RGBA32F\n", (const char *)glGetString(GL_RENDERER), (const char *)glGetString(GL_VERSION), W, H);
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    open_target(GL_RGBA32F, W, H);
    program = fill_program();
    for (i = 0; i < 4; i++) { /* drivers keep what they have compiled: __GL_SHADER_DISK_CACHE=0, MESA_SHADER_CACHE_DISABLE=1 show the first time */
        began = now();
        gl = create_gl(load, 0, i < 3 ? 2u << i : 0);
        printf("gl: shaders of %s compiled in %.1f ms\n", compiled[i], 1e3 * (now() - began));
        if (i < 3) lflare_gl_destroy(gl);
    }
    throwing = create_gl(load_lit, 0, 0);
    if (!game) bench_parts(gl, throwing, program);
    open_target(GL_RGBA16F, WIDE, HIGH); /* stays bound */
    if (has_gpu_clock()) bench_targets(gl, "lenses/nikon-80-200-mid.lens");
    for (i = 0; i < 4 && has_gpu_clock(); i++) bench_game(gl, program, i % 2 ? "lenses/heliar-tronnier.lens" : "lenses/nikon-80-200-mid.lens", i < 2 ? 8 : 0);
    if (glGetError() != GL_NO_ERROR) printf("gl: GL complained\n");
    lflare_gl_destroy(gl);
    lflare_gl_destroy(throwing);
    gl_host_close(&context);
}

/* `game`: only a game's frames, for slow GPUs. */
int main(int argc, char **argv)
{
    int game = argc > 1 && strcmp(argv[1], "game") == 0;
    if (!game) bench_cpu("lenses/canon-28-80.lens", 1);
    if (!game) bench_cpu("lenses/canon-28-80.lens", 0);
    bench_gpu(game);
    return 0;
}
