/* The picture: where ghosts lie, how much light they hold, what settings, views and lights do. The energy is checked against
   light counted ray by ray over the entrance, with the tests' own paths, rims, iris and films (oracle.h). */

#define _POSIX_C_SOURCE 200809L
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include "oracle.h"

#define PI 3.14159265358979323846
#define HELIAR "tests/data/heliar-golden.lens"
#define CANON "tests/data/canon-golden.lens"

static const double rgb_nm[3] = {650, 510, 475};
static oracle_lenses lenses;

static int setup(void **state)
{
    (void)state;
    oracle_lenses_find(&lenses);
    return 0;
}

/* ---- helpers ---- */

static lflare *open_text(const char *text, const lflare_settings *settings)
{
    lflare_desc desc;
    lflare_error error;
    lflare *flare = NULL;
    memset(&desc, 0, sizeof desc);
    desc.text = text;
    desc.text_size = strlen(text);
    if (settings != NULL) desc.settings = *settings;
    if (lflare_create(&desc, &flare, &error) < 0) fail_msg("%s", error.text);
    return flare;
}

static lflare *open_lens(const char *path, const lflare_settings *settings)
{
    char *text = oracle_read(path);
    lflare *flare;
    if (text == NULL) fail_msg("%s cannot be read", path);
    flare = open_text(text, settings);
    free(text);
    return flare;
}

static lflare_settings raw_at(double fnumber)
{
    lflare_settings s;
    memset(&s, 0, sizeof s);
    s.raw = 1;
    s.fnumber = fnumber;
    return s;
}

static lflare_light light_at(double right, double up) /* tangents */
{
    lflare_light l;
    memset(&l, 0, sizeof l);
    l.direction[0] = (float)right;
    l.direction[1] = (float)up;
    l.direction[2] = -1;
    l.color[0] = l.color[1] = l.color[2] = 1;
    return l;
}

static lflare_view view_of(int width, int height)
{
    lflare_view v;
    memset(&v, 0, sizeof v);
    v.width = width;
    v.height = height;
    return v;
}

/* A picture of its own memory, alpha 0.25 everywhere. */
static lflare_image image_of(int width, int height)
{
    lflare_image image;
    size_t i, count = (size_t)width * (size_t)height;
    memset(&image, 0, sizeof image);
    image.width = width;
    image.height = height;
    image.pixels = (float *)calloc(count * 4, sizeof(float));
    assert_non_null(image.pixels);
    for (i = 0; i < count; i++) image.pixels[4 * i + 3] = 0.25f;
    return image;
}

static size_t floats_of(const lflare_image *image) { return (size_t)image->width * (size_t)image->height * 4; }

static double sum_of(const lflare_image *image) /* of R, G and B */
{
    double sum = 0;
    size_t i, count = floats_of(image);
    for (i = 0; i < count; i++)
        if (i % 4 != 3) sum += (double)image->pixels[i];
    return sum;
}

/* Renders into a fresh picture of the view's size. */
static lflare_image picture(lflare *flare, const lflare_view *view, const lflare_light *lights, int32_t count)
{
    lflare_image image = image_of(view->width, view->height);
    assert_int_equal(lflare_frame(flare, view, lights, count), LFLARE_OK);
    assert_int_equal(lflare_render(flare, &image), LFLARE_OK);
    return image;
}

static void check_sane(const lflare_image *image, const char *what)
{
    size_t i, count = floats_of(image);
    for (i = 0; i < count; i++) {
        if (i % 4 == 3) assert_true(image->pixels[i] == 0.25f);
        else if (!(isfinite(image->pixels[i]) && image->pixels[i] >= 0)) fail_msg("%s: float %d is %g", what, (int)i, (double)image->pixels[i]);
    }
}

static int same(const lflare_image *a, const lflare_image *b) { return memcmp(a->pixels, b->pixels, floats_of(a) * sizeof(float)) == 0; }

/* All ghosts but one hidden. */
static lflare_override *all_but(const lflare_tables *t, int32_t kept, int32_t *count)
{
    lflare_override *o = (lflare_override *)calloc((size_t)t->ghost_count + 1, sizeof *o);
    int32_t g;
    assert_non_null(o);
    *count = 0;
    for (g = 0; g < t->ghost_count; g++)
        if (g != kept) {
            o[*count].first = t->pairs[g].first + 1;
            o[*count].second = t->pairs[g].second + 1;
            o[(*count)++].hide = 1;
        }
    return o;
}

static lflare *open_solo(const char *path, double fnumber, int32_t ghost, lflare_override change)
{
    lflare_settings s = raw_at(fnumber);
    lflare *flare = open_lens(path, &s);
    const lflare_tables *t = lflare_get_tables(flare);
    lflare_override *o = all_but(t, ghost, &s.override_count);
    s.overrides = o;
    change.first = t->pairs[ghost].first + 1;
    change.second = t->pairs[ghost].second + 1;
    o[s.override_count++] = change;
    assert_int_equal(lflare_configure(flare, &s, NULL), LFLARE_OK);
    free(o);
    return flare;
}

/* ---- orientation ---- */

/* A light's own image and its ghosts are where a pinhole camera with the view's field of view sees it. */
static void orientation(void **state)
{
    static const lflare_fit fits[4] = {LFLARE_FIT_WIDTH, LFLARE_FIT_HEIGHT, LFLARE_FIT_DIAGONAL, LFLARE_FIT_PHYSICAL};
    static const int sizes[4][2] = {{320, 180}, {160, 120}, {90, 160}, {320, 90}};
    static const double offsets[3][2] = {{0, 0}, {0.3, -0.2}, {-1.5, 0.7}};
    static const double fovs[3] = {0.3, 0.6, 1.2};
    lflare *flare = open_lens(HELIAR, NULL);
    int f, s, o, v, k, ghosts = 0;
    double worst = 0, worst_line = 0;
    (void)state;
    for (f = 0; f < 4; f++)
        for (s = 0; s < 4; s++)
            for (o = 0; o < 3; o++)
                for (v = 0; v < 3; v++) {
                    lflare_view view = view_of(sizes[s][0], sizes[s][1]);
                    double aspect = (double)sizes[s][0] / sizes[s][1], ndc[2] = {0.35, 0.55}, x, y, base = 0;
                    lflare_light light;
                    const lflare_frame_data *frame;
                    int32_t i;
                    view.fit = fits[f];
                    view.fov_y = (float)fovs[v];
                    view.centre[0] = (float)offsets[o][0];
                    view.centre[1] = (float)offsets[o][1];
                    light = light_at(3 * ndc[0] * tan(0.5 * fovs[v]) * aspect, 3 * ndc[1] * tan(0.5 * fovs[v]));
                    light.direction[2] = -3; /* any length */
                    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
                    frame = lflare_get_frame(flare);
                    assert_int_equal(frame->light_count, 1);
                    /* picture = -sensor; the offset moves the axis and everything else with it */
                    x = ((double)frame->centre[0] - (double)frame->lights[0].image[0]) / (double)frame->half_width;
                    y = ((double)frame->centre[1] - (double)frame->lights[0].image[1]) / (double)frame->half_height;
                    worst = fmax(worst, fmax(fabs(x - ndc[0] - offsets[o][0]), fabs(y - ndc[1] - offsets[o][1])));
                    assert_true(-frame->lights[0].image[0] > 0 && -frame->lights[0].image[1] > 0);
                    switch (f) { /* what each fit promises of the frame */
                    case 0: base = (double)frame->half_width / 18; break;
                    case 1: base = (double)frame->half_height / 12; break;
                    case 2: base = hypot((double)frame->half_width, (double)frame->half_height) / hypot(18, 12); break;
                    default: base = (double)frame->half_height / (99.23579634912436 * tan(0.5 * fovs[v])); break;
                    }
                    assert_true(fabs(base - 1) < 1e-5);
                    assert_true(fabs((double)frame->half_width / (double)frame->half_height / aspect - 1) < 1e-5);
                    for (i = 0; i < frame->instance_count; i++) {
                        lflare_footprint fp;
                        if (!lflare_footprint_resolve(lflare_get_tables(flare), frame, frame->instances[i], &fp)) continue;
                        for (k = 0; k < 3; k++) {
                            double gx = -(double)fp.channels[k].centre[0], gy = -(double)fp.channels[k].centre[1];
                            double lx = -(double)frame->lights[0].image[0], ly = -(double)frame->lights[0].image[1];
                            worst_line = fmax(worst_line, fabs(gx * ly - gy * lx) / (hypot(lx, ly) * (1 + hypot(gx, gy))));
                            ghosts++;
                        }
                    }
                }
    print_message("own image within %.1e half-frames, %d ghost centres within %.1e of the line\n", worst, ghosts, worst_line);
    assert_true(worst < 1e-5);
    assert_true(worst_line < 1e-5 && ghosts > 1000);
    lflare_destroy(flare);
}

/* Without a camera's field of view slopes are true: the image of a light 10 degrees to the right lies at -EFL tan(10). */
static void true_slopes(void **state)
{
    lflare *flare = open_lens(HELIAR, NULL);
    lflare_view view = view_of(320, 180);
    lflare_light light = light_at(tan(10 * PI / 180), 0);
    const lflare_frame_data *frame;
    int fit;
    (void)state;
    for (fit = 0; fit < 4; fit++) {
        view.fit = (lflare_fit)fit;
        assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
        frame = lflare_get_frame(flare);
        assert_true(fabs((double)frame->lights[0].image[0] + 17.4979) < 1e-3); /* 99.2358 x 0.1763270 */
        assert_true(frame->lights[0].image[1] == 0);
        assert_true(fabs((double)frame->lights[0].field_angle - 10 * PI / 180) < 1e-6);
    }
    lflare_destroy(flare);
}

/* ---- energy ---- */

typedef struct counted {
    double area, centroid, flux, centre; /* entrance mm^2 and mm along the slope; W cos(theta) area; mean sensor position along it */
} counted;

typedef struct rims {
    int count;
    double a[ORACLE_STEPS], b[ORACLE_STEPS], h[ORACLE_STEPS];
    double ma11, ma12, iris, corner[16][2];
    int blades;
} rims;

/* Is the entrance point (x along the slope, y across) let through by everything? `turn` is the slope's direction. */
static int passes(const rims *r, double x, double y, double u, double turn)
{
    int i;
    double ax = r->ma11 * x + r->ma12 * u, ay = r->ma11 * y;
    for (i = 0; i < r->count; i++) {
        double px = r->a[i] * x + r->b[i] * u, py = r->a[i] * y;
        if (px * px + py * py > r->h[i] * r->h[i]) return 0;
    }
    if (r->blades == 0) return ax * ax + ay * ay <= r->iris * r->iris;
    {
        double sx = ax * cos(turn) - ay * sin(turn), sy = ax * sin(turn) + ay * cos(turn);
        for (i = 0; i < r->blades; i++) { /* left of every side */
            const double *p = r->corner[i], *q = r->corner[(i + 1) % r->blades];
            if ((q[0] - p[0]) * (sy - p[1]) - (q[1] - p[1]) * (sx - p[0]) < 0) return 0;
        }
    }
    return 1;
}

/* Counts the light of a ghost: strata over the square around the front rim, then over the part of it that was lit. */
static counted count_light(const lflare_lens *lens, lflare_pair pair, double nm, double u, double turn, double iris, int blades, double rotation)
{
    static rims r;
    static oracle_step steps[ORACLE_STEPS];
    static oracle_matrix at[ORACLE_STEPS + 1];
    lflare_crossing path[ORACLE_STEPS];
    oracle_random random = {42};
    oracle_lens o;
    counted c = {0, 0, 0, 0};
    int32_t used = ORACLE_STEPS, i;
    double lo[2], hi[2];
    int pass, n, j, k;
    assert_int_equal(lflare_ghost_path(lens, nm, pair, path, &used), LFLARE_OK);
    r.count = 0;
    for (i = 0; i < used; i++) {
        if (path[i].surface == lens->stop) {
            r.ma11 = path[i].a;
            r.ma12 = path[i].b;
        } else {
            r.a[r.count] = path[i].a;
            r.b[r.count] = path[i].b;
            r.h[r.count++] = lens->prescription.surfaces[path[i].surface].semi_diameter;
        }
    }
    r.iris = iris;
    r.blades = blades;
    for (i = 0; i < blades; i++) {
        r.corner[i][0] = iris * cos(rotation + 2 * PI * i / blades);
        r.corner[i][1] = iris * sin(rotation + 2 * PI * i / blades);
    }
    hi[0] = hi[1] = lens->prescription.surfaces[0].semi_diameter;
    lo[0] = lo[1] = -hi[0];
    if (fabs(r.ma11) > 1e-9) { /* the iris's image, if it is smaller: no light is outside it */
        lo[0] = fmax(lo[0], -r.ma12 * u / r.ma11 - iris / fabs(r.ma11));
        hi[0] = fmin(hi[0], -r.ma12 * u / r.ma11 + iris / fabs(r.ma11));
        lo[1] = fmax(lo[1], -iris / fabs(r.ma11));
        hi[1] = fmin(hi[1], iris / fabs(r.ma11));
        if (lo[0] >= hi[0]) return c;
    }
    for (pass = 0; pass < 2; pass++) {
        int side = pass == 0 ? 150 : 500;
        double dx = (hi[0] - lo[0]) / side, dy = (hi[1] - lo[1]) / side, sx = 0;
        double next_lo[2] = {1e30, 1e30}, next_hi[2] = {-1e30, -1e30};
        long lit = 0;
        for (j = 0; j < side; j++)
            for (k = 0; k < side; k++) {
                double x = lo[0] + (j + oracle_unit(&random)) * dx, y = lo[1] + (k + oracle_unit(&random)) * dy;
                if (!passes(&r, x, y, u, turn)) continue;
                lit++;
                sx += x;
                next_lo[0] = fmin(next_lo[0], x - 2 * dx);
                next_lo[1] = fmin(next_lo[1], y - 2 * dy);
                next_hi[0] = fmax(next_hi[0], x + 2 * dx);
                next_hi[1] = fmax(next_hi[1], y + 2 * dy);
            }
        if (lit == 0) return c;
        c.area = (double)lit * dx * dy;
        c.centroid = sx / (double)lit;
        for (j = 0; j < 2; j++) {
            lo[j] = fmax(lo[j], next_lo[j]);
            hi[j] = fmin(hi[j], next_hi[j]);
        }
    }
    oracle_lens_make(&o, &lens->prescription, nm);
    n = oracle_path(&o, pair.first, pair.second, steps);
    oracle_paraxial(&o, steps, n, at);
    c.flux = c.area * oracle_weight(&o, steps, n, at, c.centroid, u) / sqrt(1 + u * u);
    c.centre = (double)(at[n].a * c.centroid + at[n].b * u);
    return c;
}

typedef struct energy_case {
    const char *what;
    double fnumber, lamp, pixels; /* of the ghost's radius; 0: as fits a 200 x 200 picture */
    int blades, rims_only;
} energy_case;

/* W as the tables have it, between two samples of the field. */
static double table_weight(const lflare_tables *t, int32_t g, int k, double angle)
{
    double x = angle / (double)t->style[g * LFLARE_STYLE_FLOATS + 6] * (LFLARE_FIELD_SAMPLES - 1);
    int j = x < LFLARE_FIELD_SAMPLES - 2 ? (int)x : LFLARE_FIELD_SAMPLES - 2;
    const float *row = t->field + (g * LFLARE_FIELD_SAMPLES + j) * LFLARE_FIELD_FLOATS;
    return (double)row[k] + (x - j) * ((double)row[k + LFLARE_FIELD_FLOATS] - (double)row[k]);
}

/* Renders one ghost alone, as large as asked, and compares the light in it, channel by channel. Returns 0 if the ghost is
   not of the case's kind. */
static int compare_energy(const char *path, lflare *flare, int32_t g, double u, double turn, const energy_case *kind, double *worst, double *worst_place,
                          int *over)
{
    const lflare_tables *t = lflare_get_tables(flare);
    const lflare_lens *lens = lflare_get_lens(flare);
    int width = kind->pixels > 0 ? 160 : 200, height = kind->pixels > 0 ? 107 : 200, pass, k;
    lflare_view view = view_of(width, height);
    lflare_light light = light_at(-u * cos(turn), -u * sin(turn)), *l = &light;
    lflare_instance instance = {0, 0, 0, 0};
    lflare_frame_light frame_light;
    lflare_frame_data frame;
    lflare_footprint fp;
    lflare_image image;
    lflare_clip clip = lflare_ghost_clip(lens, 510, t->pairs[g], (double)t->iris.radius, u, NULL);
    counted c[3];
    if (clip == LFLARE_CLIP_HIDDEN || (kind->rims_only && clip != LFLARE_CLIP_RIM && clip != LFLARE_CLIP_BOTH)) return 0;
    for (k = 0; k < 3; k++) {
        c[k] = count_light(lens, t->pairs[g], rgb_nm[k], u, turn, (double)t->iris.radius, kind->blades, 0.3);
        if (c[k].area < 1e-4 * PI * (double)t->iris.radius * (double)t->iris.radius) return 0; /* a sliver */
    }
    light.angular_radius = (float)kind->lamp;
    memset(&frame, 0, sizeof frame);
    frame.lights = &frame_light;
    frame.light_capacity = 1;
    view.fit = LFLARE_FIT_PHYSICAL;
    view.fov_y = 0.01f;
    instance.ghost = (uint16_t)g;
    for (pass = 0; pass < 3; pass++) { /* a look, then a frame around what was seen; twice, since pixels soften */
        lflare_instance none[1];
        double half, reach = 0;
        frame.instances = none;
        frame.instance_capacity = 0;
        lflare_frame_build(t, &view, l, 1, &frame); /* finds no room for instances: those are chosen here */
        frame.light_count = 1;
        if (!lflare_footprint_resolve(t, &frame, instance, &fp)) return 0;
        for (k = 0; k < 3; k++)
            reach = fmax(reach, hypot((double)(fp.channels[k].centre[0] - fp.channels[1].centre[0]), (double)(fp.channels[k].centre[1] - fp.channels[1].centre[1])));
        reach += (double)fp.radius;
        half = kind->pixels > 0 ? (double)fp.radius * 0.5 * height / kind->pixels : 1.1 * reach;
        if (kind->pixels > 0 && pass > 0) half = (double)frame.half_height; /* the size stays that of the first look */
        half = fmax(half, 1e-4);
        view.fov_y = (float)(2 * atan(half / lens->efl));
        view.centre[0] = (float)((double)fp.channels[1].centre[0] / half * height / width);
        view.centre[1] = (float)((double)fp.channels[1].centre[1] / half);
        if (!(view.fov_y < 3.0f) || fabsf(view.centre[0]) > 900 || fabsf(view.centre[1]) > 900) return 0;
        if (pass == 2 && reach > half) return 0; /* not wholly in the frame */
    }
    image = image_of(width, height);
    assert_int_equal(lflare_software_rows(&fp, 1, &t->iris, &frame, &image, 0, height), LFLARE_OK);
    check_sane(&image, kind->what);
    for (k = 0; k < 3; k++) {
        double sum = 0, mx = 0, my = 0, pixel = (double)frame.pixel, error, colour, ex, ey;
        int x, y;
        for (y = 0; y < height; y++)
            for (x = 0; x < width; x++) {
                double v = (double)image.pixels[(y * width + x) * 4 + k];
                sum += v;
                mx += v * ((double)frame.centre[0] + (0.5 * width - 0.5 - x) * pixel);
                my += v * ((double)frame.centre[1] + (y + 0.5 - 0.5 * height) * pixel);
            }
        error = sum * pixel * pixel / c[k].flux - 1;
        colour = table_weight(t, g, k, atan(u)) / (c[k].flux / c[k].area * sqrt(1 + u * u)) - 1;
        /* where the light is on average, in pixels or in hundredths of the ghost */
        ex = mx / sum - c[k].centre * cos(turn);
        ey = my / sum - c[k].centre * sin(turn);
        *worst_place = fmax(*worst_place, hypot(ex, ey) / fmax(pixel, 0.01 * (double)fp.radius));
        if (fabs(error) > *worst) *worst = fabs(error);
        if (!(fabs(error) <= 0.005)) {
            if ((*over)++ < 12)
                print_error("%s, %s: ghost (%d,%d) channel %d at %.2f degrees: %+.2f %% (colour %+.2f, shape %+.2f), clip %d, area %.3g mm^2, radius %.1f pixels, W %.1e\n", kind->what, path,
                            (int)t->pairs[g].first + 1, (int)t->pairs[g].second + 1, k, atan(u) * 180 / PI, 100 * error, 100 * colour, 100 * ((1 + error) / (1 + colour) - 1), (int)clip,
                            c[k].area, (double)fp.radius / pixel, c[k].flux / c[k].area * sqrt(1 + u * u));
        }
    }
    free(image.pixels);
    return 1;
}

static void energy(const energy_case *kind)
{
    static const double degrees[4] = {1, 5.45, 10, 16};
    int l, a, tested = 0, over = 0;
    double worst = 0, place = 0;
    for (l = 0; l < lenses.count; l++) {
        lflare_settings s = raw_at(kind->fnumber);
        lflare *flare;
        int32_t g, count;
        s.blades = kind->blades;
        s.blade_rotation = 0.3f;
        flare = open_lens(lenses.path[l], &s);
        count = lflare_get_tables(flare)->ghost_count;
        for (a = 0; a < 4; a++) {
            int here = 0;
            int32_t step = 1 + count / (kind->rims_only ? 40 : 8);
            for (g = (l + a) % step; g < count && here < 3; g += step)
                here += compare_energy(lenses.path[l], flare, g, tan(degrees[a] * PI / 180), 0.7 + a, kind, &worst, &place, &over);
            tested += here;
        }
        lflare_destroy(flare);
    }
    print_message("%s: %d ghosts, worst channel %.2f %%, %d channels over 0.5 %%; centre of light off by up to %.2f\n", kind->what, tested, 100 * worst, over,
                  place);
    assert_true(tested >= 60);
    assert_int_equal(over, 0);
}

static void energy_plain(void **state)
{
    static const energy_case kind = {"plain", 8, 0, 0, 0, 0};
    (void)state;
    energy(&kind);
}

static void energy_open(void **state)
{
    static const energy_case kind = {"wide open", 2, 0, 0, 0, 0};
    (void)state;
    energy(&kind);
}

static void energy_tiny(void **state)
{
    static const energy_case third = {"a third of a pixel", 8, 0, 0.33, 0, 0}, three = {"three pixels", 8, 0, 3, 0, 0}, five = {"five pixels", 8, 0, 5, 0, 0};
    (void)state;
    energy(&third);
    energy(&three);
    energy(&five);
}

static void energy_sun(void **state)
{
    static const energy_case kind = {"sun", 8, 0.00465, 0, 0, 0};
    (void)state;
    energy(&kind);
}

static void energy_lamp(void **state)
{
    static const energy_case kind = {"lamp", 8, 0.02, 0, 0, 0};
    (void)state;
    energy(&kind);
}

static void energy_rims(void **state)
{
    static const energy_case kind = {"rims", 4, 0, 0, 0, 1};
    (void)state;
    energy(&kind);
}

static void energy_pentagon(void **state)
{
    static const energy_case kind = {"pentagon", 8, 0, 0, 5, 0};
    (void)state;
    energy(&kind);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orientation),  cmocka_unit_test(true_slopes), cmocka_unit_test(energy_plain), cmocka_unit_test(energy_open),
        cmocka_unit_test(energy_tiny),  cmocka_unit_test(energy_sun),  cmocka_unit_test(energy_lamp),  cmocka_unit_test(energy_rims),
        cmocka_unit_test(energy_pentagon),
    };
    return cmocka_run_group_tests(tests, setup, NULL);
}
