/* The room "gl": the same picture as software in GL 3.3 and ES 3.0, state put back, missing pieces named. Skipped with a line
   where no context can be had without a window. */
#define GL_GLEXT_PROTOTYPES
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include <GL/gl.h>
#include <GL/glext.h>
#include "gl_context.h"

enum { W = 640, H = 360 };

static gl_context context;
static GLuint target, framebuffer;
static char log_text[4096];

/* ---- loaders ---- */

static const char *missing;  /* not found by the loader */
static int broken_shaders, draws, asks, waits;

static void count_draw(GLenum mode, GLint first, GLsizei count, GLsizei instances)
{
    draws++;
    glDrawArraysInstanced(mode, first, count, instances);
}

static void count_get(GLenum name, GLint *out)
{
    asks++;
    glGetIntegerv(name, out);
}

static GLboolean count_enabled(GLenum name)
{
    asks++;
    return glIsEnabled(name);
}

static void break_source(GLuint shader, GLsizei count, const char *const *pieces, const GLint *lengths)
{
    static const char *const nonsense = "this is no shader";
    (void)count;
    (void)pieces;
    (void)lengths;
    glShaderSource(shader, 1, (const GLchar *const *)&nonsense, NULL);
}

/* GL objects made and not yet deleted. */
static int live;

#define COUNTED(name)                                                                                        \
    static void gen_##name(GLsizei n, GLuint *out) { live += n; glGen##name(n, out); }                       \
    static void delete_##name(GLsizei n, const GLuint *names)                                                \
    {                                                                                                        \
        GLsizei i;                                                                                           \
        for (i = 0; i < n; i++) live -= names[i] != 0;                                                       \
        glDelete##name(n, names);                                                                            \
    }
COUNTED(Textures)
COUNTED(Buffers)
COUNTED(VertexArrays)

static GLuint create_program(void) { live++; return glCreateProgram(); }
static GLuint create_shader(GLenum kind) { live++; return glCreateShader(kind); }
static void delete_program(GLuint name) { live -= name != 0; glDeleteProgram(name); }
static void delete_shader(GLuint name) { live -= name != 0; glDeleteShader(name); }

static lflare_gl_function counted(const char *name)
{
    static const struct {
        const char *name;
        lflare_gl_function function;
    } all[] = {{"glGenTextures", (lflare_gl_function)gen_Textures}, {"glDeleteTextures", (lflare_gl_function)delete_Textures},
               {"glGenBuffers", (lflare_gl_function)gen_Buffers}, {"glDeleteBuffers", (lflare_gl_function)delete_Buffers},
               {"glGenVertexArrays", (lflare_gl_function)gen_VertexArrays}, {"glDeleteVertexArrays", (lflare_gl_function)delete_VertexArrays},
               {"glCreateProgram", (lflare_gl_function)create_program}, {"glDeleteProgram", (lflare_gl_function)delete_program},
               {"glCreateShader", (lflare_gl_function)create_shader}, {"glDeleteShader", (lflare_gl_function)delete_shader}};
    size_t i;
    for (i = 0; i < sizeof all / sizeof all[0]; i++)
        if (strcmp(name, all[i].name) == 0) return all[i].function;
    return NULL;
}

static lflare_gl_function load(const char *name)
{
    if (counted(name) != NULL && (missing == NULL || strcmp(name, missing) != 0)) return counted(name);
    if (missing != NULL && strcmp(name, missing) == 0) return NULL;
    if (strcmp(name, "glDrawArraysInstanced") == 0) return (lflare_gl_function)count_draw;
    if (strcmp(name, "glGetIntegerv") == 0) return (lflare_gl_function)count_get;
    if (strcmp(name, "glIsEnabled") == 0) return (lflare_gl_function)count_enabled;
    if (strcmp(name, "glShaderSource") == 0 && broken_shaders) return (lflare_gl_function)break_source;
    if (strcmp(name, "glReadPixels") == 0 || strcmp(name, "glFinish") == 0 || strcmp(name, "glFenceSync") == 0) waits++;
    return (lflare_gl_function)eglGetProcAddress(name);
}

static int open_target(int es)
{
    if (!gl_context_open(&context, es)) {
        print_message("no %s context without a window here: skipped\n", es ? "ES 3.0" : "GL 3.3");
        gl_context_close(&context);
        return 0;
    }
    glGenTextures(1, &target);
    glBindTexture(GL_TEXTURE_2D, target);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, W, H, 0, GL_RGBA, GL_FLOAT, NULL);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target, 0);
    assert_int_equal(glCheckFramebufferStatus(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
    glBindTexture(GL_TEXTURE_2D, 0);
    glViewport(0, 0, W, H);
    glClearColor(0, 0, 0, 0.25f);
    glClear(GL_COLOR_BUFFER_BIT);
    return 1;
}

static lflare_gl_desc describe(void)
{
    lflare_gl_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.load = load;
    desc.log = log_text;
    desc.log_size = sizeof log_text;
    return desc;
}

static lflare_gl *create(const lflare_gl_desc *desc)
{
    lflare_gl *gl;
    lflare_error error;
    if (lflare_gl_create(desc, &gl, &error) != LFLARE_OK) fail_msg("%s\n%s", error.text, log_text);
    return gl;
}

static lflare *open_lens(const char *path, double fnumber, int blades)
{
    lflare_desc desc;
    lflare_error error;
    lflare *flare;
    char *text;
    memset(&desc, 0, sizeof desc);
    assert_int_equal(lflare_file_read(path, NULL, NULL, &text, &desc.text_size, &error), LFLARE_OK);
    desc.text = text;
    desc.settings.fnumber = fnumber;
    desc.settings.blades = blades;
    desc.settings.blade_curvature = blades == 7 ? 0.4f : 0;
    desc.settings.blade_rotation = 0.3f;
    assert_int_equal(lflare_create(&desc, &flare, &error), LFLARE_OK);
    free(text);
    return flare;
}

static void one_frame(lflare *flare, float degrees, float radius, int lights)
{
    lflare_view view;
    lflare_light light[4];
    int i;
    memset(&view, 0, sizeof view);
    memset(light, 0, sizeof light);
    view.width = W;
    view.height = H;
    for (i = 0; i < lights; i++) {
        light[i].direction[0] = tanf((degrees + (float)i) * 0.0174533f);
        light[i].direction[1] = 0.4f * light[i].direction[0];
        light[i].direction[2] = -1;
        light[i].color[0] = light[i].color[1] = light[i].color[2] = 1;
        light[i].angular_radius = radius;
    }
    assert_int_equal(lflare_frame(flare, &view, light, lights), LFLARE_OK);
}

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* PSNR over lit pixels, linear, white at the 99.8th percentile of them. */
static double psnr(const float *a, const float *b)
{
    static float lit[W * H];
    size_t i, n = 0;
    double sum = 0, count = 0;
    float white;
    int k;
    for (i = 0; i < (size_t)W * H; i++) {
        float most = fmaxf(b[4 * i], fmaxf(b[4 * i + 1], b[4 * i + 2]));
        if (most > 0) lit[n++] = most;
    }
    assert_true(n > 100);
    qsort(lit, n, sizeof lit[0], by_value);
    white = lit[(size_t)((double)(n - 1) * 0.998)];
    for (i = 0; i < (size_t)W * H; i++) {
        float most = 0;
        for (k = 0; k < 3; k++) most = fmaxf(most, fmaxf(a[4 * i + (size_t)k], b[4 * i + (size_t)k]));
        if (most <= 1e-4f * white) continue;
        count += 3;
        for (k = 0; k < 3; k++) {
            double d = (double)(fminf(a[4 * i + (size_t)k] / white, 1) - fminf(b[4 * i + (size_t)k] / white, 1));
            sum += d * d;
        }
    }
    return sum > 0 ? -10 * log10(sum / count) : 999;
}

static void equals_software(int es)
{
    static const char *const paths[3] = {"lenses/heliar-tronnier.lens", "lenses/nikon-80-200-mid.lens", "lenses/planar-50-14.lens"};
    static const float degrees[3] = {2, 5.45f, 12};
    static const int blades[3] = {0, 6, 7};
    static float drawn[4 * W * H], expected[4 * W * H];
    lflare_gl_desc desc = describe();
    lflare_gl *gl;
    double worst = 999;
    int l, a, i;
    if (!open_target(es)) skip();
    gl = create(&desc);
    for (l = 0; l < 3; l++)
        for (a = 0; a < 3; a++) {
            lflare *flare = open_lens(paths[l], 5.6, blades[a]);
            lflare_image image;
            double here;
            memset(&image, 0, sizeof image);
            image.width = W;
            image.height = H;
            image.pixels = expected;
            image.bottom_up = 1;
            memset(expected, 0, sizeof expected);
            one_frame(flare, degrees[a], l == 1 ? 0.00465f : 0, 2);
            assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
            glClear(GL_COLOR_BUFFER_BIT);
            assert_int_equal(lflare_gl_draw(gl, lflare_get_tables(flare), lflare_get_frame(flare)), LFLARE_OK);
            assert_int_equal(glGetError(), GL_NO_ERROR);
            glReadPixels(0, 0, W, H, GL_RGBA, GL_FLOAT, drawn);
            for (i = 0; i < W * H; i++) assert_true(drawn[4 * i + 3] == 0.25f); /* alpha stays */
            here = psnr(drawn, expected);
            if (here < 50) print_error("%s at %g degrees, %d blades: %.1f dB\n", paths[l], (double)degrees[a], blades[a], here);
            worst = fmin(worst, here);
            lflare_destroy(flare);
        }
    print_message("GL against software, worst of 9 pictures: %.1f dB\n", worst);
    assert_true(worst >= 50);
    lflare_gl_destroy(gl);
    gl_context_close(&context);
}

static void equals_software_gl(void **state) { (void)state; equals_software(0); }
static void equals_software_es(void **state) { (void)state; equals_software(1); }

static void calls(void **state)
{
    lflare_gl_desc desc = describe();
    lflare *flare = open_lens("lenses/nikon-80-200-mid.lens", 8, 0);
    lflare_gl *gl;
    int lights;
    (void)state;
    if (!open_target(0)) { lflare_destroy(flare); skip(); }
    desc.no_restore = 1;
    waits = 0;
    gl = create(&desc);
    assert_int_equal(waits, 0); /* nothing that reads back or waits is even loaded */
    for (lights = 0; lights <= 4; lights += 2) {
        one_frame(flare, 3, 0, lights);
        lflare_gl_draw(gl, lflare_get_tables(flare), lflare_get_frame(flare)); /* uploads */
        draws = asks = 0;
        assert_int_equal(lflare_gl_draw(gl, lflare_get_tables(flare), lflare_get_frame(flare)), LFLARE_OK);
        assert_int_equal(draws, lights > 0 ? 2 : 0); /* insides and rims, however many lights */
        assert_int_equal(asks, 0);
    }
    lflare_gl_destroy(gl);
    lflare_destroy(flare);
    gl_context_close(&context);
}

/* Sets everything on the list to something unusual, draws, and compares every value. */
static void state_is_put_back(void **state)
{
    lflare_gl_desc desc = describe();
    lflare *flare = open_lens("lenses/heliar-tronnier.lens", 8, 0);
    lflare__glstate before, after;
    lflare_gl *gl;
    GLuint textures[3], samplers[3], buffers[4], array, shader;
    int k, es;
    (void)state;
    for (es = 0; es < 2; es++) {
        if (!open_target(es)) continue;
        gl = create(&desc);
        one_frame(flare, 3, 0, 1);
        glGenTextures(3, textures);
        glGenSamplers(3, samplers);
        glGenBuffers(4, buffers);
        glGenVertexArrays(1, &array);
        shader = glCreateProgram();
        for (k = 0; k < 3; k++) {
            glActiveTexture(GL_TEXTURE0 + (GLenum)k);
            glBindTexture(GL_TEXTURE_2D, textures[k]);
            glBindSampler((GLuint)k, samplers[k]);
        }
        glActiveTexture(GL_TEXTURE5);
        glBindVertexArray(array);
        glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
        glBindBuffer(GL_UNIFORM_BUFFER, buffers[1]);
        glBufferData(GL_UNIFORM_BUFFER, 4096, NULL, GL_STATIC_DRAW);
        glBindBufferRange(GL_UNIFORM_BUFFER, 0, buffers[1], 1024, 512);
        glBindBuffer(GL_UNIFORM_BUFFER, buffers[2]);
        glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffers[3]);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
        glPixelStorei(GL_UNPACK_ROW_LENGTH, 77);
        glPixelStorei(GL_UNPACK_SKIP_ROWS, 3);
        glPixelStorei(GL_UNPACK_SKIP_PIXELS, 5);
        glDisable(GL_BLEND);
        glEnable(GL_DEPTH_TEST);
        glEnable(GL_STENCIL_TEST);
        glEnable(GL_CULL_FACE);
        glEnable(GL_RASTERIZER_DISCARD);
        glEnable(GL_SAMPLE_ALPHA_TO_COVERAGE);
        glEnable(GL_SAMPLE_COVERAGE);
        if (!es) glEnable(GL_COLOR_LOGIC_OP);
        glColorMask(0, 1, 0, 1);
        glBlendFuncSeparate(GL_DST_COLOR, GL_SRC_ALPHA, GL_ONE_MINUS_DST_ALPHA, GL_ZERO);
        glBlendEquationSeparate(GL_MIN, GL_FUNC_REVERSE_SUBTRACT);
        (void)shader;
        lflare__gl_save(gl, &before);
        /* the lists' values are as set: the save itself is checked */
        assert_int_equal(before.capability[0], 0);
        for (k = 1; k < LFLARE__GL_CAPABILITY_COUNT - es; k++) assert_int_equal(before.capability[k], 1);
        assert_int_equal(before.uniform_size, 512);
        glActiveTexture(GL_TEXTURE5);
        assert_int_equal(lflare_gl_draw(gl, lflare_get_tables(flare), lflare_get_frame(flare)), LFLARE_OK);
        lflare__gl_save(gl, &after);
        before.value[LFLARE__GL_VALUE_COUNT - 1][0] = GL_TEXTURE5; /* saving itself moves the active unit */
        assert_memory_equal(&before, &after, sizeof before);
        lflare_gl_destroy(gl);
        gl_context_close(&context);
    }
    lflare_destroy(flare);
}

static void missing_functions_are_named(void **state)
{
#define NAME(result, name, arguments) "gl" #name,
    static const char *const names[] = {LFLARE__GL_FUNCTIONS(NAME)};
#undef NAME
    lflare_gl_desc desc = describe();
    lflare_gl *gl;
    lflare_error error;
    size_t i;
    (void)state;
    if (!open_target(0)) skip();
    for (i = 0; i < sizeof names / sizeof names[0]; i++) {
        missing = names[i];
        assert_int_equal(lflare_gl_create(&desc, &gl, &error), LFLARE_ERROR_GL);
        assert_null(gl);
        assert_non_null(strstr(error.text, names[i]));
    }
    missing = NULL;
    assert_int_equal(lflare_gl_draw(NULL, NULL, NULL), LFLARE_ERROR_ARGUMENT);
    lflare_gl_destroy(NULL);
    lflare_gl_forget(NULL);
    gl_context_close(&context);
}

static void failing_shader_leaves_nothing(void **state)
{
    lflare_gl_desc desc = describe();
    lflare_gl *gl;
    lflare_error error;
    (void)state;
    if (!open_target(0)) skip();
    broken_shaders = 1;
    live = 0;
    assert_int_equal(lflare_gl_create(&desc, &gl, &error), LFLARE_ERROR_GL);
    broken_shaders = 0;
    assert_null(gl);
    assert_int_equal(live, 0);
    assert_true(strlen(log_text) > 10);
    assert_int_equal(glGetError(), GL_NO_ERROR);
    gl_context_close(&context);
}

static void cycles_and_loss(void **state)
{
    lflare_gl_desc desc = describe();
    lflare *flare = open_lens("lenses/heliar-tronnier.lens", 8, 0);
    lflare_gl *gl;
    int i;
    (void)state;
    if (!open_target(0)) { lflare_destroy(flare); skip(); }
    one_frame(flare, 3, 0, 1);
    live = 0;
    for (i = 0; i < 100; i++) {
        gl = create(&desc);
        lflare_gl_draw(gl, lflare_get_tables(flare), lflare_get_frame(flare));
        lflare_gl_destroy(gl);
    }
    assert_int_equal(live, 0);
    gl = create(&desc);
    gl_context_close(&context); /* the context goes first */
    lflare_gl_forget(gl);
    assert_int_equal(lflare_gl_draw(gl, lflare_get_tables(flare), lflare_get_frame(flare)), LFLARE_ERROR_ARGUMENT);
    lflare_gl_destroy(gl);
    lflare_destroy(flare);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equals_software_gl),
        cmocka_unit_test(equals_software_es),
        cmocka_unit_test(calls),
        cmocka_unit_test(state_is_put_back),
        cmocka_unit_test(missing_functions_are_named),
        cmocka_unit_test(failing_shader_leaves_nothing),
        cmocka_unit_test(cycles_and_loss),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
