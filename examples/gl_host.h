/* gl_host: what the examples, the tool and the tests need around GL, with no GL header and no GL library to link: functions
   through any loader, a context without a window, a target to draw into, its picture read back. A game has all of this
   already; it is no part of the library. Include lensflare.h before. */
#ifndef GL_HOST_H
#define GL_HOST_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifndef _WIN32
#include <dlfcn.h>
#endif

/* One line on standard error, exit status 2: what examples do about errors. */
static inline void gl_die(const char *what, const char *why)
{
    fprintf(stderr, "%s: %s\n", what, why);
    exit(2);
}

/* ---- functions ---- */

#if defined(_WIN32) && !defined(_WIN64)
#define GL_HOST_CALL __stdcall
#else
#define GL_HOST_CALL
#endif

/* One row per function: result, name, arguments. All are in GL 3.3 core and in ES 3.0. */
#define GL_API_FUNCTIONS(X)                                                                             \
    X(void, ActiveTexture, (unsigned))                                                                  \
    X(void, AttachShader, (unsigned, unsigned))                                                         \
    X(void, BindFramebuffer, (unsigned, unsigned))                                                      \
    X(void, BindTexture, (unsigned, unsigned))                                                          \
    X(void, BindVertexArray, (unsigned))                                                                \
    X(unsigned, CheckFramebufferStatus, (unsigned))                                                     \
    X(void, Clear, (unsigned))                                                                          \
    X(void, ClearBufferfv, (unsigned, int, const float *))                                              \
    X(void, ClearColor, (float, float, float, float))                                                   \
    X(void, CompileShader, (unsigned))                                                                  \
    X(unsigned, CreateProgram, (void))                                                                  \
    X(unsigned, CreateShader, (unsigned))                                                               \
    X(void, DeleteFramebuffers, (int, const unsigned *))                                                \
    X(void, DeleteProgram, (unsigned))                                                                  \
    X(void, DeleteShader, (unsigned))                                                                   \
    X(void, DeleteTextures, (int, const unsigned *))                                                    \
    X(void, DeleteVertexArrays, (int, const unsigned *))                                                \
    X(void, DepthFunc, (unsigned))                                                                      \
    X(void, Disable, (unsigned))                                                                        \
    X(void, DrawArrays, (unsigned, int, int))                                                           \
    X(void, Enable, (unsigned))                                                                         \
    X(void, FramebufferTexture2D, (unsigned, unsigned, unsigned, unsigned, int))                        \
    X(void, GenFramebuffers, (int, unsigned *))                                                         \
    X(void, GenTextures, (int, unsigned *))                                                             \
    X(void, GenVertexArrays, (int, unsigned *))                                                         \
    X(unsigned, GetError, (void))                                                                       \
    X(void, GetProgramInfoLog, (unsigned, int, int *, char *))                                          \
    X(void, GetProgramiv, (unsigned, unsigned, int *))                                                  \
    X(void, GetShaderInfoLog, (unsigned, int, int *, char *))                                           \
    X(void, GetShaderiv, (unsigned, unsigned, int *))                                                   \
    X(int, GetUniformLocation, (unsigned, const char *))                                                \
    X(void, LinkProgram, (unsigned))                                                                    \
    X(void, ReadPixels, (int, int, int, int, unsigned, unsigned, void *))                               \
    X(void, ShaderSource, (unsigned, int, const char *const *, const int *))                            \
    X(void, TexImage2D, (unsigned, int, int, int, int, int, unsigned, unsigned, const void *))          \
    X(void, TexParameteri, (unsigned, unsigned, int))                                                   \
    X(void, Uniform1f, (int, float))                                                                    \
    X(void, Uniform3f, (int, float, float, float))                                                      \
    X(void, UniformMatrix4fv, (int, int, unsigned char, const float *))                                 \
    X(void, UseProgram, (unsigned))                                                                     \
    X(void, Viewport, (int, int, int, int))

#define GL_API_MEMBER(result, name, arguments) result(GL_HOST_CALL *name) arguments;
typedef struct gl_api {
    GL_API_FUNCTIONS(GL_API_MEMBER)
} gl_api;
#undef GL_API_MEMBER

/* Spelled as in GL's own headers, so that both may be included. */
#define GL_NO_ERROR 0
#define GL_TRIANGLES 0x0004
#define GL_DEPTH_BUFFER_BIT 0x00000100
#define GL_LESS 0x0201
#define GL_GREATER 0x0204
#define GL_DEPTH_TEST 0x0B71
#define GL_TEXTURE_2D 0x0DE1
#define GL_UNSIGNED_BYTE 0x1401
#define GL_UNSIGNED_INT 0x1405
#define GL_FLOAT 0x1406
#define GL_COLOR 0x1800
#define GL_DEPTH 0x1801
#define GL_DEPTH_COMPONENT 0x1902
#define GL_RGBA 0x1908
#define GL_NEAREST 0x2600
#define GL_TEXTURE_MAG_FILTER 0x2800
#define GL_TEXTURE_MIN_FILTER 0x2801
#define GL_COLOR_BUFFER_BIT 0x00004000
#define GL_RGBA8 0x8058
#define GL_DEPTH_COMPONENT24 0x81A6
#define GL_TEXTURE0 0x84C0
#define GL_RGBA32F 0x8814
#define GL_RGBA16F 0x881A
#define GL_FRAGMENT_SHADER 0x8B30
#define GL_VERTEX_SHADER 0x8B31
#define GL_COMPILE_STATUS 0x8B81
#define GL_LINK_STATUS 0x8B82
#define GL_SRGB8_ALPHA8 0x8C43
#define GL_FRAMEBUFFER_COMPLETE 0x8CD5
#define GL_COLOR_ATTACHMENT0 0x8CE0
#define GL_DEPTH_ATTACHMENT 0x8D00
#define GL_FRAMEBUFFER 0x8D40
#define GL_FRAMEBUFFER_SRGB 0x8DB9

/* With a context current. NULL if all functions are there, else the name of the first that is missing. */
static inline const char *gl_api_load(gl_api *gl, lflare_gl_loader load)
{
    lflare_gl_function f;
#define GL_API_LOAD(result, name, arguments)  \
    f = load("gl" #name);                     \
    if (f == NULL) return "gl" #name;         \
    memcpy(&gl->name, &f, sizeof f);
    GL_API_FUNCTIONS(GL_API_LOAD)
#undef GL_API_LOAD
    return NULL;
}

/* ---- a context without a window ---- */

/* Both libraries are looked for at run time: EGL, surfaceless where it can, and Mesa's OSMesa where there is no EGL. */
#define GL_HOST_EGL(X)                                                         \
    X(unsigned, BindAPI, (unsigned))                                           \
    X(unsigned, ChooseConfig, (void *, const int *, void **, int, int *))      \
    X(void *, CreateContext, (void *, void *, void *, const int *))            \
    X(unsigned, DestroyContext, (void *, void *))                              \
    X(void *, GetDisplay, (void *))                                            \
    X(int, GetError, (void))                                                   \
    X(lflare_gl_function, GetProcAddress, (const char *))                      \
    X(unsigned, Initialize, (void *, int *, int *))                            \
    X(unsigned, MakeCurrent, (void *, void *, void *, void *))                 \
    X(unsigned, Terminate, (void *))

#define GL_HOST_OSMESA(X)                                                      \
    X(void *, CreateContextAttribs, (const int *, void *))                     \
    X(void, DestroyContext, (void *))                                          \
    X(lflare_gl_function, GetProcAddress, (const char *))                      \
    X(unsigned char, MakeCurrent, (void *, void *, unsigned, int, int))

#define GL_HOST_MEMBER(result, name, arguments) result(*name) arguments;
typedef struct gl_host {
    lflare_gl_loader load; /* for gl_api_load and lflare_gl_create */
    char why[240];         /* one line on why there is no context */
    void *library, *display, *context;
    struct { GL_HOST_EGL(GL_HOST_MEMBER) } egl;
    struct { GL_HOST_OSMESA(GL_HOST_MEMBER) } osmesa;
    unsigned char pixels[16 * 16 * 4]; /* OSMesa's window, which nothing is drawn to */
} gl_host;
#undef GL_HOST_MEMBER

#ifdef _WIN32

static inline void gl_host_close(gl_host *h) { (void)h; }

static inline int gl_host_open(gl_host *h, const char *which, int es)
{
    (void)which;
    (void)es;
    memset(h, 0, sizeof *h);
    strcpy(h->why, "a GL context without a window is not available on Windows");
    return 0;
}

#else

/* The library stays loaded: unloaded, Mesa would lose memory that it keeps. */
static inline void gl_host_close(gl_host *h)
{
    if (h->display != NULL) {
        h->egl.MakeCurrent(h->display, NULL, NULL, NULL);
        if (h->context != NULL) h->egl.DestroyContext(h->display, h->context);
        h->egl.Terminate(h->display);
    } else if (h->context != NULL) {
        h->osmesa.MakeCurrent(NULL, NULL, 0, 0, 0);
        h->osmesa.DestroyContext(h->context);
    }
    h->library = h->display = h->context = NULL;
    h->load = NULL;
}

/* Closes what was opened so far and adds to `why`. */
static inline int gl_host_fail(gl_host *h, const char *reason, int egl_error)
{
    size_t n = strlen(h->why), room = sizeof h->why - n;
    const char *join = n > 0 ? "; " : "";
    if (egl_error != 0) snprintf(h->why + n, room, "%s%s (EGL error 0x%x)", join, reason, (unsigned)egl_error);
    else snprintf(h->why + n, room, "%s%s", join, reason);
    gl_host_close(h);
    return 0;
}

static inline int gl_host_library(gl_host *h, const char *name, const char *other_name)
{
    h->library = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    if (h->library == NULL) h->library = dlopen(other_name, RTLD_NOW | RTLD_LOCAL);
    return h->library != NULL;
}

static inline int gl_host_symbol(const gl_host *h, const char *name, void *function)
{
    void *symbol = dlsym(h->library, name);
    memcpy(function, &symbol, sizeof symbol);
    return symbol != NULL;
}

/* `display` once it works, else NULL. */
static inline void *gl_host_egl_working(const gl_host *h, void *display)
{
    return display != NULL && h->egl.Initialize(display, NULL, NULL) ? display : NULL;
}

/* The first GPU that works, by EGL's list of them. */
static inline void *gl_host_egl_gpu(const gl_host *h, void *(*platform_display)(unsigned, void *, const int *))
{
    enum { DEVICE = 0x313F, MOST = 16 };
    unsigned (*query)(int, void **, int *) = (unsigned (*)(int, void **, int *))h->egl.GetProcAddress("eglQueryDevicesEXT");
    void *devices[MOST], *display = NULL;
    int count = 0, i;
    if (query == NULL || platform_display == NULL || !query(MOST, devices, &count)) return NULL;
    for (i = 0; i < count && display == NULL; i++) display = gl_host_egl_working(h, platform_display(DEVICE, devices[i], NULL));
    return display;
}

/* Mesa's surfaceless platform needs neither a screen nor a GPU; else whatever this EGL takes for its default display; else a GPU by
   its place in EGL's list, which is all that some drivers know without a screen. `gpu`: that one alone. */
static inline void *gl_host_egl_display(const gl_host *h, int gpu)
{
    enum { SURFACELESS = 0x31DD };
    void *(*platform_display)(unsigned, void *, const int *) = (void *(*)(unsigned, void *, const int *))h->egl.GetProcAddress("eglGetPlatformDisplayEXT");
    void *display = NULL;
    if (!gpu && platform_display != NULL) display = gl_host_egl_working(h, platform_display(SURFACELESS, NULL, NULL));
    if (!gpu && display == NULL) display = gl_host_egl_working(h, h->egl.GetDisplay(NULL));
    return display != NULL ? display : gl_host_egl_gpu(h, platform_display);
}

static inline int gl_host_open_egl(gl_host *h, int gpu, int es)
{
    enum { SURFACE_TYPE = 0x3033, RENDERABLE_TYPE = 0x3040, GL_BIT = 0x8, ES3_BIT = 0x40, MAJOR = 0x3098, MINOR = 0x30FB, PROFILE = 0x30FD, CORE = 1,
           NONE = 0x3038, ES_API = 0x30A0, GL_API = 0x30A2 };
    static const int core[] = {MAJOR, 3, MINOR, 3, PROFILE, CORE, NONE}, es3[] = {MAJOR, 3, MINOR, 0, NONE};
    int wanted[] = {SURFACE_TYPE, 0, RENDERABLE_TYPE, GL_BIT, NONE}, count = 0;
    void *config = NULL;
    if (!gl_host_library(h, "libEGL.so.1", "libEGL.so")) return gl_host_fail(h, "libEGL.so.1 cannot be loaded", 0);
#define GL_HOST_SYMBOL(result, name, arguments) \
    if (!gl_host_symbol(h, "egl" #name, &h->egl.name)) return gl_host_fail(h, "libEGL.so.1 has no egl" #name, 0);
    GL_HOST_EGL(GL_HOST_SYMBOL)
#undef GL_HOST_SYMBOL
    h->display = gl_host_egl_display(h, gpu);
    if (h->display == NULL) return gl_host_fail(h, "EGL has no display without a window", h->egl.GetError());
    if (!h->egl.BindAPI(es ? ES_API : GL_API)) return gl_host_fail(h, es ? "EGL has no GL ES" : "EGL has no desktop GL", h->egl.GetError());
    if (es) wanted[3] = ES3_BIT;
    if (!h->egl.ChooseConfig(h->display, wanted, &config, 1, &count) || count < 1) config = NULL; /* may do without */
    h->context = h->egl.CreateContext(h->display, config, NULL, es ? es3 : core);
    if (h->context == NULL) return gl_host_fail(h, es ? "EGL gives no ES 3.0 context" : "EGL gives no GL 3.3 context", h->egl.GetError());
    if (!h->egl.MakeCurrent(h->display, NULL, NULL, h->context)) return gl_host_fail(h, "EGL needs a surface", h->egl.GetError());
    h->load = h->egl.GetProcAddress;
    return 1;
}

static inline int gl_host_open_osmesa(gl_host *h, int es)
{
    enum { FORMAT = 0x22, PROFILE = 0x33, CORE = 0x34, MAJOR = 0x36, MINOR = 0x37 };
    static const int core[] = {FORMAT, GL_RGBA, PROFILE, CORE, MAJOR, 3, MINOR, 3, 0};
    if (es) return gl_host_fail(h, "OSMesa has no GL ES", 0);
    if (!gl_host_library(h, "libOSMesa.so.8", "libOSMesa.so")) return gl_host_fail(h, "libOSMesa.so.8 cannot be loaded", 0);
#define GL_HOST_SYMBOL(result, name, arguments) \
    if (!gl_host_symbol(h, "OSMesa" #name, &h->osmesa.name)) return gl_host_fail(h, "libOSMesa.so.8 has no OSMesa" #name, 0);
    GL_HOST_OSMESA(GL_HOST_SYMBOL)
#undef GL_HOST_SYMBOL
    h->context = h->osmesa.CreateContextAttribs(core, NULL);
    if (h->context == NULL) return gl_host_fail(h, "OSMesa gives no GL 3.3 context", 0);
    if (!h->osmesa.MakeCurrent(h->context, h->pixels, GL_UNSIGNED_BYTE, 16, 16)) return gl_host_fail(h, "OSMesa's context cannot be made current", 0);
    h->load = h->osmesa.GetProcAddress;
    return 1;
}

/* Makes a context current: GL 3.3 core, or ES 3.0 if `es`. `which`: "egl"; "gpu", EGL on the first GPU that it lists; "osmesa"; or NULL,
   then the environment's GL_HOST, and without that EGL first, OSMesa else. Returns 1 and h->load, or 0 and h->why. Do not move *h until
   gl_host_close. Draw into a framebuffer object: the window, if there is one at all, is a dummy. */
static inline int gl_host_open(gl_host *h, const char *which, int es)
{
    memset(h, 0, sizeof *h);
    if (which == NULL) which = getenv("GL_HOST");
    if (which == NULL || which[0] == 0) return gl_host_open_egl(h, 0, es) || gl_host_open_osmesa(h, es);
    if (strcmp(which, "egl") == 0) return gl_host_open_egl(h, 0, es);
    if (strcmp(which, "gpu") == 0) return gl_host_open_egl(h, 1, es);
    if (strcmp(which, "osmesa") == 0) return gl_host_open_osmesa(h, es);
    return gl_host_fail(h, "GL_HOST is none of egl, gpu, osmesa", 0);
}

#endif

/* ---- targets ---- */

/* A framebuffer with a texture for its colour and, if asked for, one for its depth. */
typedef struct gl_target {
    unsigned framebuffer, color, depth;
    int width, height;
} gl_target;

static inline void gl_target_close(const gl_api *gl, gl_target *t)
{
    gl->DeleteFramebuffers(1, &t->framebuffer);
    gl->DeleteTextures(1, &t->color);
    gl->DeleteTextures(1, &t->depth); /* 0 is ignored */
    memset(t, 0, sizeof *t);
}

static inline unsigned gl_target_texture(const gl_api *gl, const gl_target *t, int internal, unsigned format, unsigned type, unsigned attachment)
{
    unsigned texture;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexImage2D(GL_TEXTURE_2D, 0, internal, t->width, t->height, 0, format, type, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture, 0);
    return texture;
}

/* `format`: GL_RGBA8, GL_SRGB8_ALPHA8, GL_RGBA16F or GL_RGBA32F. Returns 1 with the target bound, its viewport set, its
   contents undefined; or 0 and nothing left. */
static inline int gl_target_open(const gl_api *gl, gl_target *t, int format, int width, int height, int with_depth)
{
    memset(t, 0, sizeof *t);
    t->width = width;
    t->height = height;
    gl->GenFramebuffers(1, &t->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    t->color = gl_target_texture(gl, t, format, GL_RGBA, format == GL_RGBA8 || format == GL_SRGB8_ALPHA8 ? GL_UNSIGNED_BYTE : GL_FLOAT, GL_COLOR_ATTACHMENT0);
    if (with_depth) t->depth = gl_target_texture(gl, t, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, GL_DEPTH_ATTACHMENT);
    gl->BindTexture(GL_TEXTURE_2D, 0);
    gl->Viewport(0, 0, width, height);
    if (gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return 1;
    gl_target_close(gl, t);
    return 0;
}

/* The bound framebuffer's lower left part as RGBA floats, the top row first, as lflare_image has them. Waits for GL. */
static inline int gl_read_floats(const gl_api *gl, int width, int height, float *rgba)
{
    size_t row = (size_t)width * 4, x;
    int y;
    gl->ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, rgba); /* GL begins with the bottom row */
    for (y = 0; y < height / 2; y++) {
        float *a = rgba + (size_t)y * row, *b = rgba + (size_t)(height - 1 - y) * row;
        for (x = 0; x < row; x++) {
            float swap = a[x];
            a[x] = b[x];
            b[x] = swap;
        }
    }
    return gl->GetError() == GL_NO_ERROR;
}

/* The bound framebuffer's lower left part as a PPM picture, bytes as they are. Returns 0 if it cannot be read or written. */
static inline int gl_write_ppm(const gl_api *gl, int width, int height, const char *path)
{
    unsigned char *rgba = (unsigned char *)malloc((size_t)width * (size_t)height * 4);
    FILE *file = fopen(path, "wb");
    int done = rgba != NULL && file != NULL, x, y;
    if (done) {
        gl->ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
        done = gl->GetError() == GL_NO_ERROR;
        fprintf(file, "P6\n%d %d\n255\n", width, height);
        for (y = height - 1; y >= 0; y--)
            for (x = 0; x < width; x++) fwrite(rgba + 4 * ((size_t)y * (size_t)width + (size_t)x), 1, 3, file);
        done = done && !ferror(file);
    }
    if (file != NULL && fclose(file) != 0) done = 0;
    free(rgba);
    return done;
}

/* ---- programs ---- */

static inline unsigned gl_shader(const gl_api *gl, unsigned kind, const char *source)
{
    unsigned shader = gl->CreateShader(kind);
    char log[1000];
    int done = 0;
    gl->ShaderSource(shader, 1, &source, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (done) return shader;
    gl->GetShaderInfoLog(shader, (int)sizeof log, NULL, log);
    fprintf(stderr, "a shader does not compile: %s\n", log);
    gl->DeleteShader(shader);
    return 0;
}

/* 0, and the log on standard error, if it cannot be built. */
static inline unsigned gl_program(const gl_api *gl, const char *vertex_source, const char *fragment_source)
{
    unsigned vertex = gl_shader(gl, GL_VERTEX_SHADER, vertex_source), fragment = gl_shader(gl, GL_FRAGMENT_SHADER, fragment_source), program = 0;
    char log[1000];
    int done = 0;
    if (vertex != 0 && fragment != 0) {
        program = gl->CreateProgram();
        gl->AttachShader(program, vertex);
        gl->AttachShader(program, fragment);
        gl->LinkProgram(program);
        gl->GetProgramiv(program, GL_LINK_STATUS, &done);
        if (!done) {
            gl->GetProgramInfoLog(program, (int)sizeof log, NULL, log);
            fprintf(stderr, "a program does not link: %s\n", log);
            gl->DeleteProgram(program);
            program = 0;
        }
    }
    gl->DeleteShader(vertex); /* 0 is ignored */
    gl->DeleteShader(fragment);
    return program;
}

/* ---- a window ---- */

/* Only where GLFW was included before. */
#ifdef GLFW_VERSION_MAJOR

/* A window with a context of GL 3.3 core, current, shown at the screen's pace. `srgb`: its framebuffer can encode on write. NULL,
   and *why, if there is none. Either way glfwTerminate ends it. */
static inline GLFWwindow *gl_window_open(const char *title, int width, int height, int srgb, const char **why)
{
    GLFWwindow *window = NULL;
    *why = "no window is to be had";
    if (glfwInit()) {
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE); /* macOS wants it */
        glfwWindowHint(GLFW_SRGB_CAPABLE, srgb);
        window = glfwCreateWindow(width, height, title, NULL, NULL);
    }
    if (window == NULL) {
        glfwGetError(why);
        return NULL;
    }
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    return window;
}

#endif
#endif
