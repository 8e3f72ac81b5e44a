/* Prints, as JavaScript, every call that the room "gl" makes for a few frames, with the software renderer's pictures of the
   same frames: tests/webgl.html repeats the calls in a browser's WebGL 2 and compares. What GL is asked is answered as a
   fresh context would, and asked again in the browser. Usage: webgl_record >calls.js */
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"

enum { W = 320, H = 180, TARGET = 1000, DEPTH = 1001 }; /* names of the page's own framebuffer and texture */

static void print_base64(const void *data, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *p = (const unsigned char *)data;
    size_t i;
    printf("bytes('");
    for (i = 0; i < size; i += 3) {
        unsigned a = p[i], b = i + 1 < size ? p[i + 1] : 0u, c = i + 2 < size ? p[i + 2] : 0u, all = a << 16 | b << 8 | c;
        putchar(digits[all >> 18]);
        putchar(digits[all >> 12 & 63]);
        putchar(i + 1 < size ? digits[all >> 6 & 63] : '=');
        putchar(i + 2 < size ? digits[all & 63] : '=');
    }
    printf("')");
}

/* ---- a GL that writes down ---- */

/* Functions that only act: name, arguments, what the page does. */
#define ACTS(X)                                                                                                                        \
    X(ActiveTexture, (unsigned a), "'activeTexture', %u", a)                                                                           \
    X(AttachShader, (unsigned a, unsigned b), "'attachShader', o.program[%u], o.shader[%u]", a, b)                                     \
    X(BindAttribLocation, (unsigned a, unsigned b, const char *c), "'bindAttribLocation', o.program[%u], %u, '%s'", a, b, c)           \
    X(BindBuffer, (unsigned a, unsigned b), "'bindBuffer', %u, o.buffer[%u]", a, b)                                                    \
    X(BindBufferBase, (unsigned a, unsigned b, unsigned c), "'bindBufferBase', %u, %u, o.buffer[%u]", a, b, c)                         \
    X(BindBufferRange, (unsigned a, unsigned b, unsigned c, ptrdiff_t d, ptrdiff_t e), "'bindBufferRange', %u, %u, o.buffer[%u], %ld, %ld", \
      a, b, c, (long)d, (long)e)                                                                                                       \
    X(BindFramebuffer, (unsigned a, unsigned b), "'bindFramebuffer', %u, o.framebuffer[%u]", a, b)                                     \
    X(BindSampler, (unsigned a, unsigned b), "'bindSampler', %u, o.sampler[%u]", a, b)                                                 \
    X(BindTexture, (unsigned a, unsigned b), "'bindTexture', %u, o.texture[%u]", a, b)                                                 \
    X(BindVertexArray, (unsigned a), "'bindVertexArray', o.array[%u]", a)                                                              \
    X(BlendEquationSeparate, (unsigned a, unsigned b), "'blendEquationSeparate', %u, %u", a, b)                                        \
    X(BlendFuncSeparate, (unsigned a, unsigned b, unsigned c, unsigned d), "'blendFuncSeparate', %u, %u, %u, %u", a, b, c, d)          \
    X(ClearBufferfv, (unsigned a, int b, const float *c), "'clearBufferfv', %u, %d, [%.9g, %.9g, %.9g, %.9g]", a, b, (double)c[0],     \
      (double)c[1], (double)c[2], (double)c[3])                                                                                        \
    X(ColorMask, (unsigned char a, unsigned char b, unsigned char c, unsigned char d), "'colorMask', %d, %d, %d, %d", a, b, c, d)      \
    X(CompileShader, (unsigned a), "'compileShader', o.shader[%u]", a)                                                                 \
    X(DeleteProgram, (unsigned a), "'deleteProgram', o.program[%u]", a)                                                                \
    X(DeleteShader, (unsigned a), "'deleteShader', o.shader[%u]", a)                                                                   \
    X(Disable, (unsigned a), "'disable', %u", a)                                                                                       \
    X(DrawArraysInstanced, (unsigned a, int b, int c, int d), "'drawArraysInstanced', %u, %d, %d, %d", a, b, c, d)                     \
    X(DrawElementsInstanced, (unsigned a, int b, unsigned c, const void *d, int e), "'drawElementsInstanced', %u, %d, %u, %ld, %d", a, b, c, \
      (long)(ptrdiff_t)d, e)                                                                                                           \
    X(Enable, (unsigned a), "'enable', %u", a)                                                                                         \
    X(EnableVertexAttribArray, (unsigned a), "'enableVertexAttribArray', %u", a)                                                       \
    X(FramebufferTexture2D, (unsigned a, unsigned b, unsigned c, unsigned d, int e),                                                   \
      "'framebufferTexture2D', %u, %u, %u, o.texture[%u], %d", a, b, c, d, e)                                                          \
    X(LinkProgram, (unsigned a), "'linkProgram', o.program[%u]", a)                                                                    \
    X(PixelStorei, (unsigned a, int b), "'pixelStorei', %u, %d", a, b)                                                                 \
    X(SamplerParameteri, (unsigned a, unsigned b, int c), "'samplerParameteri', o.sampler[%u], %u, %d", a, b, c)                       \
    X(TexParameteri, (unsigned a, unsigned b, int c), "'texParameteri', %u, %u, %d", a, b, c)                                          \
    X(Uniform1i, (int a, int b), "'uniform1i', o.place[%d], %d", a, b)                                                                 \
    X(Uniform3f, (int a, float b, float c, float d), "'uniform3f', o.place[%d], %.9g, %.9g, %.9g", a, (double)b, (double)c, (double)d) \
    X(UniformBlockBinding, (unsigned a, unsigned b, unsigned c), "'uniformBlockBinding', o.program[%u], %u, %u", a, b, c)              \
    X(UseProgram, (unsigned a), "'useProgram', o.program[%u]", a)                                                                      \
    X(VertexAttribDivisor, (unsigned a, unsigned b), "'vertexAttribDivisor', %u, %u", a, b)                                            \
    X(VertexAttribIPointer, (unsigned a, int b, unsigned c, int d, const void *e), "'vertexAttribIPointer', %u, %d, %u, %d, %ld", a,   \
      b, c, d, (long)(ptrdiff_t)e)                                                                                                     \
    X(Viewport, (int a, int b, int c, int d), "'viewport', %d, %d, %d, %d", a, b, c, d)

#define DEFINE(name, arguments, ...)   \
    static void gl_##name arguments    \
    {                                  \
        printf("call(" __VA_ARGS__);   \
        printf(");\n");                \
    }
ACTS(DEFINE)

/* Objects: made, deleted, kept by name in o.KIND. */
static unsigned names = 1;

#define OBJECTS(X) X(Buffers, buffer, Buffer) X(Framebuffers, framebuffer, Framebuffer) X(Samplers, sampler, Sampler) \
    X(Textures, texture, Texture) X(VertexArrays, array, VertexArray)

#define DEFINE_OBJECT(plural, kind, single)                                                                    \
    static void gl_Gen##plural(int n, unsigned *out)                                                           \
    {                                                                                                          \
        int i;                                                                                                 \
        for (i = 0; i < n; i++) printf("o." #kind "[%u] = gl.create" #single "();\n", out[i] = names++);       \
    }                                                                                                          \
    static void gl_Delete##plural(int n, const unsigned *in)                                                   \
    {                                                                                                          \
        int i;                                                                                                 \
        for (i = 0; i < n; i++) printf("call('delete" #single "', o." #kind "[%u]);\n", in[i]);                \
    }
OBJECTS(DEFINE_OBJECT)

static unsigned gl_CreateProgram(void)
{
    printf("o.program[%u] = gl.createProgram();\n", names);
    return names++;
}

static unsigned gl_CreateShader(unsigned kind)
{
    printf("o.shader[%u] = gl.createShader(%u);\n", names, kind);
    return names++;
}

/* The GLSL holds neither backslashes nor backquotes. */
static void gl_ShaderSource(unsigned shader, int count, const char *const *pieces, const int *lengths)
{
    int i;
    (void)lengths;
    printf("call('shaderSource', o.shader[%u], `", shader);
    for (i = 0; i < count; i++) printf("%s", pieces[i]);
    printf("`);\n");
}

static void gl_BufferData(unsigned target, ptrdiff_t size, const void *data, unsigned usage)
{
    printf("call('bufferData', %u, ", target);
    if (data != NULL) print_base64(data, (size_t)size);
    else printf("%ld", (long)size);
    printf(", %u);\n", usage);
}

static void gl_BufferSubData(unsigned target, ptrdiff_t at, ptrdiff_t size, const void *data)
{
    printf("call('bufferSubData', %u, %ld, ", target, (long)at);
    print_base64(data, (size_t)size);
    printf(");\n");
}

static void gl_TexImage2D(unsigned target, int level, int internal, int width, int height, int border, unsigned format, unsigned type, const void *data)
{
    size_t texel = internal == 0x8814 ? 16 : 4; /* RGBA32F and R32UI are what is uploaded */
    printf("call('texImage2D', %u, %d, %d, %d, %d, %d, %u, %u, ", target, level, internal, width, height, border, format, type);
    if (data != NULL) {
        printf("texels(%u, ", type);
        print_base64(data, texel * (size_t)width * (size_t)height);
        printf(")");
    } else {
        printf("null");
    }
    printf(");\n");
}

/* ---- what GL is asked ---- */

static const unsigned char *gl_GetString(unsigned name)
{
    (void)name;
    return (const unsigned char *)"OpenGL ES 3.0 (WebGL 2.0 (recorder))";
}

static unsigned gl_CheckFramebufferStatus(unsigned target)
{
    printf("complete(%u);\n", target);
    return 0x8CD5;
}

static void gl_GetShaderiv(unsigned shader, unsigned name, int *out)
{
    (void)shader;
    (void)name;
    *out = 1;
}

static void gl_GetProgramiv(unsigned program, unsigned name, int *out)
{
    printf("linked(%u, %u);\n", program, name);
    *out = 1;
}

static void gl_GetInfoLog(unsigned object, int size, int *length, char *out)
{
    (void)object;
    (void)length;
    if (size > 0) out[0] = 0;
}

static unsigned gl_GetUniformBlockIndex(unsigned program, const char *name)
{
    printf("block(%u, '%s');\n", program, name);
    return 0; /* every program has one at most */
}

static int gl_GetUniformLocation(unsigned program, const char *name)
{
    printf("place(%u, %u, '%s');\n", names, program, name);
    return (int)names++;
}

static unsigned char gl_IsEnabled(unsigned name)
{
    printf("call('isEnabled', %u);\n", name);
    return 0;
}

/* A fresh context's values, the page's framebuffer and viewport, and how the page unpacks. */
static void gl_GetIntegerv(unsigned name, int *out)
{
    static const struct {
        unsigned name;
        int value[4];
    } values[] = {{0x0C23, {1, 1, 1, 1}}, {0x80C9, {1}}, {0x80CB, {1}}, {0x8009, {0x8006}}, {0x883D, {0x8006}}, {0x0CF5, {4}}, {0x8CA6, {TARGET}},
                  {0x0BA2, {0, 0, W, H}}, {0x84E0, {0x84C0}}, {0x9240, {1}}, {0x9241, {1}}, {0x0D33, {4096}}};
    size_t i;
    printf("call('getParameter', %u);\n", name);
    *out = 0;
    for (i = 0; i < sizeof values / sizeof values[0]; i++)
        if (values[i].name == name) memcpy(out, values[i].value, name == 0x0C23 || name == 0x0BA2 ? sizeof values[i].value : sizeof(int));
}

static void gl_GetIntegeri_v(unsigned name, unsigned index, int *out)
{
    printf("call('getIndexedParameter', %u, %u);\n", name, index);
    *out = 0;
}

static void gl_GetInteger64i_v(unsigned name, unsigned index, int64_t *out)
{
    printf("call('getIndexedParameter', %u, %u);\n", name, index);
    *out = 0;
}

static lflare_gl_function load(const char *name)
{
#define ROW(name) {"gl" #name, (lflare_gl_function)gl_##name},
#define ACT_ROW(name, arguments, ...) ROW(name)
#define OBJECT_ROWS(plural, kind, single) ROW(Gen##plural) ROW(Delete##plural)
    static const struct {
        const char *name;
        lflare_gl_function function;
    } all[] = {ACTS(ACT_ROW) OBJECTS(OBJECT_ROWS) ROW(CreateProgram) ROW(CreateShader) ROW(ShaderSource) ROW(BufferData) ROW(BufferSubData)
               ROW(TexImage2D) ROW(GetString) ROW(CheckFramebufferStatus) ROW(GetShaderiv) ROW(GetProgramiv)
               ROW(GetUniformBlockIndex) ROW(GetUniformLocation) ROW(IsEnabled) ROW(GetIntegerv) ROW(GetIntegeri_v) ROW(GetInteger64i_v)
               {"glGetShaderInfoLog", (lflare_gl_function)gl_GetInfoLog}, {"glGetProgramInfoLog", (lflare_gl_function)gl_GetInfoLog}};
    size_t i;
    for (i = 0; i < sizeof all / sizeof all[0]; i++)
        if (strcmp(name, all[i].name) == 0) return all[i].function;
    return NULL;
}

/* ---- frames ---- */

static lflare *open_lens(const char *path, double fnumber, int blades)
{
    lflare_desc desc = {0};
    lflare_error error;
    lflare *flare;
    char *text;
    if (lflare_file_read(path, NULL, NULL, &text, &desc.text_size, &error) < 0) exit(2);
    desc.text = text;
    desc.settings.fnumber = fnumber;
    desc.settings.blades = blades;
    desc.settings.blade_curvature = 0.2f;
    if (lflare_create(&desc, &flare, &error) < 0) exit(2);
    free(text);
    return flare;
}

/* A lamp right of the middle and a bluish one left of it, the first as large as asked. */
static void set_lights(lflare_light *lights, float radius)
{
    int i;
    memset(lights, 0, 2 * sizeof *lights);
    for (i = 0; i < 2; i++) {
        lights[i].direction[0] = i == 0 ? 0.0954f : -0.06f;
        lights[i].direction[1] = 0.03f;
        lights[i].direction[2] = -1;
        lights[i].color[0] = lights[i].color[1] = i == 0 ? 1.0f : 0.3f;
        lights[i].color[2] = 1;
    }
    lights[0].angular_radius = radius;
}

/* The camera whose depth buffer it is: that of the lens. */
static lflare_gl_depth camera(const lflare *flare)
{
    const lflare_tables *tables = lflare_get_tables(flare);
    lflare_gl_depth depth = {0};
    depth.texture = DEPTH;
    depth.projection[0] = 2 * tables->efl / tables->sensor_width;
    depth.projection[5] = depth.projection[0] * W / H;
    depth.projection[10] = depth.projection[11] = -1;
    depth.projection[14] = -0.1f;
    return depth;
}

static void expect(lflare *flare, const lflare_light *lights, const char *what, double db)
{
    static float pixels[4 * W * H];
    lflare_view view = {0};
    lflare_image image = {pixels, W, H, 0, 1};
    view.width = W;
    view.height = H;
    memset(pixels, 0, sizeof pixels);
    lflare_frame(flare, &view, lights, 2);
    lflare_render(flare, &image);
    printf("compare('%s', ", what);
    print_base64(pixels, sizeof pixels);
    printf(", %g);\n", db);
}

/* hidden: the depth buffer's right half is near, its left half far. */
static void frame(lflare_gl *gl, const char *path, double fnumber, int blades, float radius, int half, int hidden)
{
    lflare *flare = open_lens(path, fnumber, blades);
    lflare_gl_depth depth = camera(flare);
    lflare_view view = {0};
    lflare_light lights[2];
    char what[200];
    lflare_result result;
    view.width = W;
    view.height = H;
    set_lights(lights, radius);
    lflare_frame(flare, &view, lights, 2);
    printf("clear();\n");
    result = lflare_gl_occlusion(gl, lights, 2, hidden ? &depth : NULL);
    if (result == LFLARE_OK && half) result = lflare_gl_draw_half(gl, lflare_get_tables(flare), lflare_get_frame(flare));
    if (result == LFLARE_OK) result = half ? lflare_gl_add_half(gl) : lflare_gl_draw(gl, lflare_get_tables(flare), lflare_get_frame(flare));
    if (result != LFLARE_OK) exit(2);
    if (hidden) lights[0].occlusion[0] = lights[0].occlusion[1] = lights[0].occlusion[2] = 1;
    sprintf(what, "%.60s, f/%g, %d blades%s%s", lflare_get_lens(flare)->prescription.name, fnumber, blades, half ? ", half size" : "",
            hidden ? ", one light hidden" : "");
    expect(flare, lights, what, half ? 30 : 45);
    lflare_destroy(flare);
}

int main(void)
{
    lflare_gl_desc desc = {0};
    lflare_gl *gl;
    lflare_error error;
    desc.load = load;
    printf("begin(%d, %d, %d, %d);\n", W, H, TARGET, DEPTH);
    if (lflare_gl_create(&desc, &gl, &error) < 0) {
        fprintf(stderr, "%s\n", error.text);
        return 2;
    }
    frame(gl, "lenses/heliar-tronnier.lens", 8, 0, 0, 0, 0);
    frame(gl, "lenses/nikon-80-200-mid.lens", 5.6, 6, 0.00465f, 0, 0);
    frame(gl, "lenses/nikon-80-200-mid.lens", 8, 0, 0, 1, 0);
    frame(gl, "lenses/heliar-tronnier.lens", 11, 7, 0, 0, 1);
    lflare_gl_destroy(gl);
    printf("end();\n");
    return 0;
}
