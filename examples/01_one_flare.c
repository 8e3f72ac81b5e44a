/* 01_one_flare: the flare of one lens in a window. The mouse moves the sun, the wheel turns the iris, Escape quits.
   Usage: 01_one_flare [LENS] [--headless OUT.ppm], which draws one picture without a window. A game copies open_lens,
   open_renderer, turn_iris and draw. Read 03_hdr_occlusion.c next: HDR, tone mapping, a sun that things pass before. */

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include "gl_host.h"

typedef struct app {
    lflare *flare;       /* the lens: tables and frames, on the CPU */
    lflare_gl *renderer; /* what draws them */
    lflare_settings settings;
    int iris_moved, configuring;
    gl_api gl;
} app;

static void open_lens(app *a, const char *path)
{
    lflare_desc desc = {.settings = a->settings};
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
    a->gl.Enable(GL_FRAMEBUFFER_SRGB); /* light adds up linearly and is encoded on write */
}

/* A new iris comes in slices, a few ghosts a frame, so that no frame is late; until it is whole, the old one is drawn. */
static void turn_iris(app *a)
{
    if (a->iris_moved && !a->configuring) {
        a->configuring = lflare_configure_begin(a->flare, &a->settings, NULL) >= 0;
        a->iris_moved = 0;
    }
    if (a->configuring) a->configuring = lflare_configure_step(a->flare, 8) == LFLARE_INCOMPLETE;
}

/* A frame into the bound framebuffer. x and y: the sun's place in the picture, -1 to 1, right and up. */
static void draw(app *a, int width, int height, float x, float y)
{
    lflare_view view = {.width = width, .height = height, .fov_y = 0.9f}; /* the game's camera; radians */
    float up = tanf(view.fov_y / 2), right = up * (float)width / (float)height;
    lflare_light sun = {.direction = {x * right, y * up, -1}, .color = {1, 1, 1}, .angular_radius = 0.00465f}; /* camera space */
    a->gl.Viewport(0, 0, width, height);
    a->gl.ClearColor(0, 0, 0, 1);
    a->gl.Clear(GL_COLOR_BUFFER_BIT); /* a game draws its scene here */
    if (lflare_frame(a->flare, &view, &sun, 1) < 0) gl_die("lflare_frame", "the view or the light is not valid");
    if (lflare_gl_draw(a->renderer, lflare_get_tables(a->flare), lflare_get_frame(a->flare)) < 0) gl_die("GL", "the flare cannot be drawn");
}

static void on_wheel(GLFWwindow *window, double dx, double dy)
{
    app *a = (app *)glfwGetWindowUserPointer(window);
    (void)dx;
    a->settings.fnumber = fmin(fmax(a->settings.fnumber * pow(2, -dy / 6), lflare_get_lens(a->flare)->fnumber), 22); /* 1/3 stop */
    a->iris_moved = 1;
}

static void run_window(app *a)
{
    const char *why;
    GLFWwindow *window = gl_window_open("01_one_flare", 1280, 720, GLFW_TRUE, &why);
    if (window == NULL) gl_die("GLFW", why);
    open_renderer(a, glfwGetProcAddress);
    glfwSetWindowUserPointer(window, a);
    glfwSetScrollCallback(window, on_wheel);
    glfwSetInputMode(window, GLFW_STICKY_KEYS, GLFW_TRUE);
    while (!glfwWindowShouldClose(window) && glfwGetKey(window, GLFW_KEY_ESCAPE) != GLFW_PRESS) {
        int width, height, pixels_x, pixels_y;
        double x, y;
        glfwGetCursorPos(window, &x, &y); /* in units of the window's size; the framebuffer may be finer */
        glfwGetWindowSize(window, &width, &height);
        glfwGetFramebufferSize(window, &pixels_x, &pixels_y);
        turn_iris(a);
        if (pixels_x > 0 && pixels_y > 0) draw(a, pixels_x, pixels_y, (float)(2 * x / width - 1), (float)(1 - 2 * y / height));
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    lflare_gl_destroy(a->renderer);
    glfwTerminate();
}

static void run_headless(app *a, const char *out)
{
    gl_host host;
    gl_target target;
    if (!gl_host_open(&host, NULL, 0)) gl_die("GL", host.why);
    open_renderer(a, host.load);
    if (!gl_target_open(&a->gl, &target, GL_SRGB8_ALPHA8, 1280, 720, 0)) gl_die("GL", "no framebuffer");
    draw(a, target.width, target.height, 0.4f, 0.3f);
    if (!gl_write_ppm(&a->gl, target.width, target.height, out)) gl_die(out, "cannot be written");
    gl_target_close(&a->gl, &target);
    lflare_gl_destroy(a->renderer);
    gl_host_close(&host);
}

int main(int argc, char **argv)
{
    app a = {.settings = {.fnumber = 8, .blades = 6}};
    int headless = argc > 2 && strcmp(argv[argc - 2], "--headless") == 0;
    open_lens(&a, argc > (headless ? 3 : 1) ? argv[1] : "lenses/planar-50-14.lens");
    if (headless) run_headless(&a, argv[argc - 1]);
    else run_window(&a);
    lflare_destroy(a.flare);
    return 0;
}
