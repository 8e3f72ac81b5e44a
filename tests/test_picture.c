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
    s.no_starburst = s.no_ringing = 1;
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
                            double gx = -(double)fp.centre[k][0], gy = -(double)fp.centre[k][1];
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
    double area, centroid, weight, centre; /* entrance mm^2 and mm along the slope; W; mean sensor position along it */
    double lo, hi, across;                 /* bounds of the lit part, mm on the entrance along the slope and across */
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

/* Counts the light of a ghost: strata over the square around the front rim, then over the part of it that was lit. Of a lamp
   the middle is counted: soft edges leave a ghost's energy as it is. */
static counted count_light(const lflare_lens *lens, lflare_pair pair, double nm, double u, double turn, double iris, int blades, double rotation)
{
    static rims r;
    static oracle_step steps[ORACLE_STEPS];
    static oracle_matrix at[ORACLE_STEPS + 1];
    lflare_crossing path[ORACLE_STEPS];
    oracle_random random = {42};
    oracle_lens o;
    counted c = {0, 0, 0, 0, 0, 0, 0};
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
    for (pass = 0; pass < 3; pass++) { /* slivers of which the first pass finds a few points only are found whole by the second */
        int side = pass < 2 ? 100 : 360, margin;
        double dx = (hi[0] - lo[0]) / side, dy = (hi[1] - lo[1]) / side, sx = 0;
        double next_lo[2] = {1e30, 1e30}, next_hi[2] = {-1e30, -1e30};
        long lit = 0;
        for (k = 0, j = 0; j < r.count; j++) { /* rims that hold the whole rectangle need no more looking at */
            double px = fmax(fabs(r.a[j] * lo[0] + r.b[j] * u), fabs(r.a[j] * hi[0] + r.b[j] * u)), py = fmax(fabs(r.a[j] * lo[1]), fabs(r.a[j] * hi[1]));
            if (hypot(px, py) <= r.h[j]) continue;
            r.a[k] = r.a[j];
            r.b[k] = r.b[j];
            r.h[k++] = r.h[j];
        }
        r.count = k;
        for (j = 0; j < side; j++)
            for (k = 0; k < side; k++) {
                double x = lo[0] + (j + oracle_unit(&random)) * dx, y = lo[1] + (k + oracle_unit(&random)) * dy;
                if (!passes(&r, x, y, u, turn)) continue;
                lit++;
                sx += x;
                next_lo[0] = fmin(next_lo[0], x);
                next_lo[1] = fmin(next_lo[1], y);
                next_hi[0] = fmax(next_hi[0], x);
                next_hi[1] = fmax(next_hi[1], y);
            }
        if (lit == 0) return c;
        c.area = (double)lit * dx * dy;
        c.centroid = sx / (double)lit;
        margin = lit < 1000 ? 15 : 2;
        for (j = 0; j < 2; j++) {
            lo[j] = fmax(lo[j], next_lo[j] - margin * (j == 0 ? dx : dy));
            hi[j] = fmin(hi[j], next_hi[j] + margin * (j == 0 ? dx : dy));
        }
    }
    oracle_lens_make(&o, &lens->prescription, nm);
    n = oracle_path(&o, pair.first, pair.second, steps);
    oracle_paraxial(&o, steps, n, at);
    c.lo = lo[0];
    c.hi = hi[0];
    c.across = fmax(-lo[1], hi[1]);
    c.weight = oracle_weight(&o, steps, n, at, c.centroid, u);
    c.centre = (double)at[n].a * c.centroid + (double)at[n].b * u;
    return c;
}

/* What all crossings of a path leave at a slope; iris: its radius. */
static double area_of_all(const lflare_lens *lens, const lflare_crossing *path, int32_t used, double iris, double u)
{
    static lflare_circle all[LFLARE_MAX_CIRCLES];
    int32_t i;
    for (i = 0; i < used; i++) {
        double a = fmax(fabs(path[i].a), 1e-7) * (path[i].a < 0 ? -1 : 1);
        all[i].centre = -path[i].b / a;
        all[i].radius = (path[i].surface == lens->stop ? iris : lens->prescription.surfaces[path[i].surface].semi_diameter) / fabs(a);
    }
    return lflare_region_of(all, used, u, NULL).area;
}

/* What a lamp lights over what its middle would: rims that just do not cut the ghost of the middle cut those of parts of the lamp. The disc in
   rings of equal areas. */
static double lamp_share(const lflare_lens *lens, lflare_pair pair, double nm, double iris, double u, double lamp)
{
    enum { RINGS = 10, PLACES = 20 };
    lflare_crossing path[ORACLE_STEPS];
    int32_t used = ORACLE_STEPS, i, k;
    double sum = 0;
    assert_int_equal(lflare_ghost_path(lens, nm, pair, path, &used), LFLARE_OK);
    for (i = 0; i < RINGS; i++)
        for (k = 0; k < PLACES; k++) {
            double r = lamp * sqrt((i + 0.5) / RINGS), angle = PI * (k + 0.5) / PLACES; /* both halves are alike */
            sum += area_of_all(lens, path, used, iris, hypot(u + r * cos(angle), r * sin(angle)));
        }
    return sum / (RINGS * PLACES) / area_of_all(lens, path, used, iris, u);
}

/* The rims that the tables keep leave what all crossings together leave: the same area, wide open, over the whole field. */
static void kept_rims(void **state)
{
    int l, tested = 0, over = 0;
    double worst = 0;
    (void)state;
    for (l = 0; l < lenses.count; l++) {
        lflare_settings s = raw_at(0);
        lflare *flare = open_lens(lenses.path[l], &s);
        const lflare_tables *t = lflare_get_tables(flare);
        const lflare_lens *lens = lflare_get_lens(flare);
        int32_t g, k, j, i, used;
        for (g = 0; g < t->ghost_count; g++)
            for (k = 0; k < 3; k++) {
                static lflare_circle all[LFLARE_MAX_CIRCLES], kept[LFLARE_MAX_RIMS + 2];
                lflare_crossing path[ORACLE_STEPS];
                double entrance = lens->prescription.surfaces[0].semi_diameter, whole = 0, hidden = tan((double)t->style[g * LFLARE_STYLE_FLOATS + 6]);
                int32_t rims_kept = (int32_t)t->head[g * LFLARE_HEAD_FLOATS + 14];
                used = ORACLE_STEPS;
                assert_int_equal(lflare_ghost_path(lens, rgb_nm[k], t->pairs[g], path, &used), LFLARE_OK);
                for (i = 0; i < used; i++) {
                    double a = fmax(fabs(path[i].a), 1e-7) * (path[i].a < 0 ? -1 : 1);
                    double h = lens->prescription.surfaces[path[i].surface].semi_diameter;
                    all[i].centre = -path[i].b / a;
                    all[i].radius = h / fabs(a);
                    if (path[i].surface == lens->stop) kept[1] = all[i];
                }
                kept[0].centre = 0;
                kept[0].radius = entrance;
                for (i = 0; i < rims_kept; i++) {
                    const float *rim = t->rims + (g * LFLARE_MAX_RIMS + i) * LFLARE_RIM_FLOATS + k * 4;
                    double a = fmax(fabs((double)rim[0]), 1e-7) * (rim[0] < 0 ? -1 : 1);
                    kept[2 + i].centre = -(double)rim[1] / a;
                    kept[2 + i].radius = (double)rim[2] / fabs(a);
                }
                for (j = 0; j <= 40; j++) whole = fmax(whole, lflare_region_of(all, used, fmin(hidden, tan(65 * PI / 180)) * j / 40, NULL).area);
                for (j = 0; j <= 40; j++) {
                    double u = fmin(hidden, tan(65 * PI / 180)) * j / 40, exact = lflare_region_of(all, used, u, NULL).area;
                    double error = lflare_region_of(kept, 2 + rims_kept, u, NULL).area - exact;
                    if (whole <= 0) continue;
                    error = fabs(error) / whole;
                    tested++;
                    worst = fmax(worst, error);
                    if (error > 0.005 && over++ < 6)
                        print_error("%s: ghost (%d,%d) channel %d at %.2f degrees: area off by %.2f %% of its largest, %d rims kept\n", lenses.path[l],
                                    (int)t->pairs[g].first + 1, (int)t->pairs[g].second + 1, (int)k, atan(u) * 180 / PI, 100 * error, (int)rims_kept);
                }
            }
        lflare_destroy(flare);
    }
    print_message("kept rims: %d areas, worst %.2f %% of the ghost's largest, %d over 0.5 %%\n", tested, 100 * worst, over);
    assert_true(tested > 50000);
    assert_int_equal(over, 0);
}

typedef struct energy_case {
    const char *what;
    double fnumber, lamp, pixels; /* of the ghost's radius; 0: as fits a 200 x 200 picture */
    int blades, rims_only;
} energy_case;

/* W as the tables have it, by Lagrange's cubic through four samples of the field, and how far it may be off. Where W bends in a corner, as where
   a rim takes over from another one, a cubic errs by 3 / 16 of the bend at the most, which is the sum of the samples' second differences. Where it
   falls to nothing, since on the way light is totally reflected, it does so within a sample, over which the tables blend. */
static double table_weight(const lflare_tables *t, int32_t g, int k, double angle, double *doubt)
{
    double x = angle / (double)t->style[g * LFLARE_STYLE_FLOATS + 6] * (LFLARE_FIELD_SAMPLES - 1), w = 0, p[4];
    int first = x < 2 ? 0 : x < LFLARE_FIELD_SAMPLES - 3 ? (int)x - 1 : LFLARE_FIELD_SAMPLES - 4, i, j;
    for (i = 0; i < 4; i++) {
        double share = 1;
        for (j = 0; j < 4; j++)
            if (j != i) share *= (x - first - j) / (i - j);
        p[i] = (double)t->field[(g * LFLARE_FIELD_SAMPLES + first + i) * LFLARE_FIELD_FLOATS + k];
        w += share * p[i];
    }
    *doubt = 3.0 / 16 * (fabs(p[0] - 2 * p[1] + p[2]) + fabs(p[1] - 2 * p[2] + p[3]));
    for (i = 0; i < 4; i++)
        for (j = 0; j < 4; j++)
            if (p[i] <= 1e-6 * p[j]) *doubt = fmax(*doubt, p[j]);
    return fmax(w, 0);
}

/* Soft edges keep a ghost's energy where they have room. Where two of them meet in a sliver hardly wider than they are soft,
   a lamp's edges have no exact area, and neither has the lamp itself the energy of its middle: those are counted apart. */
static int washed;
static double washed_worst;

/* Of soft edges over each other the two that cut most count at a pixel, as if neither knew of the other. Over most ghosts of 36 lenses at four
   angles that leaves up to 2.2 % too much of a lamp's light (nikon-80-200-mid, ghost (13,8) at 16 degrees), 1.1 % of a sun's. */
#define MIXED 0.025
static int mixed;

/* How much larger a footprint is drawn than its entrance is. */
static double drawn_by(const lflare_footprint *fp, int k, const lflare_tables *t, int32_t g)
{
    return (double)t->head[g * LFLARE_HEAD_FLOATS + k * 4] / ((double)fp->edges[0].gain[k] * (double)t->iris.radius);
}

static int has_room(const lflare_footprint *fp, int k, const lflare_tables *t, const lflare_lens *lens, int32_t g, double u)
{
    double drawn = fabs(drawn_by(fp, k, t, g)), soft = 0;
    lflare_region region;
    int e;
    if (fp->edge_count == 1) return 1;
    for (e = 0; e < fp->edge_count; e++) soft = fmax(soft, (double)fp->edges[e].soft[k] / fabs((double)fp->edges[e].gain[k]));
    lflare_ghost_clip(lens, rgb_nm[k], t->pairs[g], (double)t->iris.radius, u, &region);
    return (region.hi - region.lo) * drawn > 8 * soft;
}

/* The square around the lit part of a footprint, soft edges included: its middle and half its side. */
static double lit_square(const lflare_footprint *fp, const lflare_tables *t, int32_t g, const counted *c, double *middle)
{
    double soft = 0, ends[2] = {1e30, -1e30}, across = 0;
    int e, k;
    for (k = 0; k < 3; k++) {
        double drawn = drawn_by(fp, k, t, g);
        double centre = (double)(fp->centre[k][0] * fp->axis[0] + fp->centre[k][1] * fp->axis[1]), a = centre + drawn * (c[k].lo - c[1].centroid), b = centre + drawn * (c[k].hi - c[1].centroid);
        ends[0] = fmin(ends[0], fmin(a, b));
        ends[1] = fmax(ends[1], fmax(a, b));
        across = fmax(across, fabs(drawn) * c[k].across);
        for (e = 0; e < fp->edge_count; e++) soft = fmax(soft, (double)fp->edges[e].soft[k] / fabs((double)fp->edges[e].gain[k]));
    }
    for (k = 0; k < 2; k++) middle[k] = 0.5 * (ends[0] + ends[1]) * (double)fp->axis[k];
    return 1.05 * fmax(0.5 * (ends[1] - ends[0]), across) + fmin(soft, (double)fp->radius);
}

/* Renders one ghost alone, as large as asked, and compares the light in it, channel by channel. Returns 0 if the ghost is
   not of the case's kind. */
static int compare_energy(const char *path, lflare *flare, int32_t g, double u, double turn, const energy_case *kind, double *worst, double *worst_place,
                          int *over, int *over_colour)
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
    int several; /* soft edges over each other */
    if (clip == LFLARE_CLIP_HIDDEN || (kind->rims_only && clip != LFLARE_CLIP_RIM && clip != LFLARE_CLIP_BOTH)) return 0;
    for (k = 0; k < 3; k++) {
        c[k] = count_light(lens, t->pairs[g], rgb_nm[k], u, turn, (double)t->iris.radius, kind->blades, (double)0.3f);
        if (kind->blades > 0) /* colours are those at the centroid of the round iris, whatever the blades */
            c[k].weight = count_light(lens, t->pairs[g], rgb_nm[k], u, turn, (double)t->iris.radius, 0, 0).weight;
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
        double half, reach = 0, middle[2];
        frame.instances = none;
        frame.instance_capacity = 0;
        lflare_frame_build(t, &view, l, 1, &frame); /* finds no room for instances: those are chosen here */
        frame.light_count = 1;
        if (!lflare_footprint_resolve(t, &frame, instance, &fp)) return 0;
        reach = lit_square(&fp, t, g, c, middle);
        half = kind->pixels > 0 ? (double)fp.radius * 0.5 * height / kind->pixels : 1.05 * reach;
        if (kind->pixels > 0 && pass > 0) half = (double)frame.half_height; /* the size stays that of the first look */
        half = fmax(half, 1e-4);
        view.fov_y = (float)(2 * atan(half / lens->efl));
        view.centre[0] = (float)(middle[0] / half * height / width);
        view.centre[1] = (float)(middle[1] / half);
        if (!(view.fov_y < 3.0f) || fabsf(view.centre[0]) > 900 || fabsf(view.centre[1]) > 900) return 0;
        if (pass == 2 && reach > half) return 0; /* not wholly in the frame */
    }
    several = kind->lamp > 0 && fp.edge_count > 1;
    image = image_of(width, height);
    assert_int_equal(lflare_software_rows(&fp, 1, &t->iris, &frame, &image, 0, height), LFLARE_OK);
    check_sane(&image, kind->what);
    for (k = 0; k < 3; k++) {
        double sum = 0, mx = 0, my = 0, pixel = (double)frame.pixel, table, doubt, light_up, shape, colour, ex, ey;
        int x, y;
        for (y = 0; y < height; y++)
            for (x = 0; x < width; x++) {
                double v = (double)image.pixels[(y * width + x) * 4 + k];
                sum += v;
                mx += v * ((double)frame.centre[0] + (0.5 * width - 0.5 - x) * pixel);
                my += v * ((double)frame.centre[1] + (y + 0.5 - 0.5 * height) * pixel);
            }
        table = table_weight(t, g, k, atan(u), &doubt);
        colour = (table - c[k].weight) / fmax(c[k].weight, 1e-30);
        *over_colour += fabs(colour) > 0.005;
        if (!(fabs(table - c[k].weight) <= 0.005 * c[k].weight + doubt) && (*over)++ < 6)
            print_error("%s, %s: ghost (%d,%d) channel %d at %.2f degrees: W %g, from the tables %g, which may be off by %g\n", kind->what, path, (int)t->pairs[g].first + 1,
                        (int)t->pairs[g].second + 1, k, atan(u) * 180 / PI, c[k].weight, table, doubt);
        if (!(sum > 0)) { /* total reflection */
            assert_true(table < 1e-12);
            continue;
        }
        light_up = c[k].area * table / sqrt(1 + u * u);
        /* what is smaller than the lamp's own image is drawn as large as that, with the light of the lamp's middle */
        if (kind->lamp > 0 && fabs(drawn_by(&fp, k, t, g)) < 1.001 * fabs((double)t->head[g * LFLARE_HEAD_FLOATS + k * 4 + 2])) light_up *= lamp_share(lens, t->pairs[g], rgb_nm[k], (double)t->iris.radius, u, kind->lamp);
        shape = sum * pixel * pixel / light_up - 1;
        /* where the light is on average, in pixels or in hundredths of the ghost */
        ex = mx / sum - c[k].centre * cos(turn);
        ey = my / sum - c[k].centre * sin(turn);
        if (!has_room(&fp, k, t, lens, g, u)) {
            washed++;
            washed_worst = fmax(washed_worst, fabs(shape));
            continue;
        }
        *worst_place = fmax(*worst_place, hypot(ex, ey) / fmax(pixel, 0.01 * (double)fp.radius));
        *worst = fmax(*worst, fabs(shape));
        mixed += several && fabs(shape) > 0.005;
        if (!(fabs(shape) <= (several ? MIXED : 0.005)) && (*over)++ < 6)
            print_error("%s, %s: ghost (%d,%d) channel %d at %.2f degrees: %+.2f %%, clip %d, area %.3g mm^2, radius %.1f pixels, W %.1e\n", kind->what, path,
                        (int)t->pairs[g].first + 1, (int)t->pairs[g].second + 1, k, atan(u) * 180 / PI, 100 * shape, (int)clip, c[k].area, (double)fp.radius / pixel, c[k].weight);
    }
    free(image.pixels);
    return 1;
}

/* Which ghosts of a lens a case looks at: others in each, and the same ones whatever other lenses there are. */
static int32_t first_pick(const char *path, const char *what)
{
    const char *parts[2];
    uint32_t hash = 2166136261u; /* FNV-1a */
    int i;
    parts[0] = strrchr(path, '/') + 1;
    parts[1] = what;
    for (i = 0; i < 2; i++)
        for (; *parts[i] != 0; parts[i]++) hash = (hash ^ (uint8_t)*parts[i]) * 16777619u;
    return (int32_t)(hash >> 8);
}

static void energy(const energy_case *kind)
{
    static const double degrees[4] = {1, 5.45, 10, 16};
    int l, a, tested = 0, over = 0, over_colour = 0;
    double worst = 0, place = 0;
    washed = mixed = 0;
    washed_worst = 0;
    for (l = 0; l < lenses.count; l++) {
        lflare_settings s = raw_at(kind->fnumber);
        lflare *flare;
        int32_t g, count, first = first_pick(lenses.path[l], kind->what);
        s.blades = kind->blades;
        s.blade_rotation = 0.3f;
        flare = open_lens(lenses.path[l], &s);
        count = lflare_get_tables(flare)->ghost_count;
        for (a = 0; a < 4; a++) {
            int here = 0;
            int32_t step = 1 + count / (kind->rims_only ? 40 : 8);
            for (g = (first + a) % step; g < count && here < 2; g += step)
                here += compare_energy(lenses.path[l], flare, g, tan(degrees[a] * PI / 180), 0.7 + a, kind, &worst, &place, &over, &over_colour);
            tested += here;
        }
        lflare_destroy(flare);
    }
    print_message("%s: %d ghosts, worst channel %.2f %%, %d of several soft edges over 0.5 %%, colours of %d bend by over 0.5 %%; centre of light off by up to %.2f; %d slivers apart, worst %.1f %%\n",
                  kind->what, tested, 100 * worst, mixed, over_colour, place, washed, 100 * washed_worst);
    assert_true(washed < tested && (kind->lamp > 0 || washed_worst < 0.02)); /* of three times as many channels */
    assert_true(tested >= 60);
    assert_true(mixed * 10 < tested * 3 && over_colour * 10 < tested * 3); /* of three channels each */
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

/* ---- colour ---- */

/* What is drawn is undone: irradiance times the drawn magnification's square, for a point of light and a tiny pixel. */
static int drawn_weight(const lflare_tables *t, int32_t g, double angle, double *w)
{
    lflare_frame_data frame;
    lflare_frame_light light;
    lflare_instance instance = {0, 0, 0, 0};
    lflare_footprint fp;
    int k;
    memset(&frame, 0, sizeof frame);
    memset(&light, 0, sizeof light);
    light.slope[0] = light.slope_length = (float)tan(angle);
    light.axis[0] = 1;
    light.field_angle = (float)angle;
    light.irradiance[0] = light.irradiance[1] = light.irradiance[2] = 1;
    frame.lights = &light;
    frame.light_count = 1;
    frame.pixel = 1e-9f;
    instance.ghost = (uint16_t)g;
    if (!lflare_footprint_resolve(t, &frame, instance, &fp)) return 0;
    for (k = 0; k < 3; k++) {
        double drawn = (double)t->head[g * LFLARE_HEAD_FLOATS + k * 4] / ((double)fp.edges[0].gain[k] * (double)t->iris.radius);
        w[k] = (double)fp.irradiance[k] * drawn * drawn;
    }
    return 1;
}

/* W of every ghost over the light's angle, from 0 to 25 degrees: finite, and continuous: where it changes by more than 1 % of
   its largest within 0.1 degrees, the change spreads out when that step is halved twelve times, following its larger half.
   A jump would stay. (Total reflection takes a colour from all to nothing within a sample of the field, which may be 0.03 degrees.) */
static void colour_continuous(void **state)
{
    int l, steep = 0, outside = 0, jumps = 0;
    long tested = 0;
    double worst = 0, worst_left = 0;
    (void)state;
    for (l = 0; l < lenses.count; l++) {
        lflare_settings s = raw_at(8);
        lflare *flare = open_lens(lenses.path[l], &s);
        lflare_tables t = *lflare_get_tables(flare);
        const lflare_lens *lens = lflare_get_lens(flare);
        int32_t g, k, i;
        for (k = 0; k < 3; k++) t.wavelengths[k] = 1e-6f; /* no diffraction: W alone is wanted */
        for (g = 0; g < t.ghost_count; g++) {
            const double step = 0.1 * PI / 180;
            double w[251][3], most[3] = {0, 0, 0};
            int lit[251];
            for (i = 0; i <= 250; i++) {
                lflare_region region;
                double u = tan(i * step), centre = -(double)t.head[g * LFLARE_HEAD_FLOATS + 5] / (double)t.head[g * LFLARE_HEAD_FLOATS + 4] * u;
                lit[i] = drawn_weight(&t, g, i * step, w[i]);
                for (k = 0; k < 3 && lit[i]; k++) {
                    if (!isfinite(w[i][k]) || w[i][k] < 0) fail_msg("%s: ghost %d at %.1f degrees: W %g", lenses.path[l], (int)g, 0.1 * i, w[i][k]);
                    most[k] = fmax(most[k], w[i][k]);
                }
                if (lit[i] && lflare_ghost_clip(lens, 510, t.pairs[g], (double)t.iris.radius, u, &region) != LFLARE_CLIP_HIDDEN)
                    outside += centre < region.lo || centre > region.hi; /* the iris's centre is not in the lit part */
            }
            for (i = 1; i <= 250; i++)
                for (k = 0; k < 3 && lit[i] && lit[i - 1] && most[k] > 0; k++) {
                    double change = fabs(w[i][k] - w[i - 1][k]) / most[k], left = change, from = (i - 1) * step, to = i * step;
                    double a[3], b[3], m[3];
                    int halving;
                    tested++;
                    worst = fmax(worst, change);
                    if (change <= 0.01) continue;
                    steep++;
                    memcpy(a, w[i - 1], sizeof a);
                    memcpy(b, w[i], sizeof b);
                    for (halving = 0; halving < 12; halving++) {
                        double middle = 0.5 * (from + to);
                        assert_true(drawn_weight(&t, g, middle, m));
                        if (fabs(m[k] - a[k]) > fabs(b[k] - m[k])) {
                            to = middle;
                            memcpy(b, m, sizeof b);
                        } else {
                            from = middle;
                            memcpy(a, m, sizeof a);
                        }
                        left = fabs(b[k] - a[k]) / most[k];
                    }
                    worst_left = fmax(worst_left, left);
                    if (left > 0.01 && jumps++ < 20)
                        print_error("%s: ghost (%d,%d) channel %d jumps by %.2f %% at %.2f degrees\n", lenses.path[l], (int)t.pairs[g].first + 1,
                                    (int)t.pairs[g].second + 1, (int)k, 100 * left, from * 180 / PI);
                }
        }
        lflare_destroy(flare);
    }
    print_message("colours: %ld steps of 0.1 degrees, steepest %.2f %%, %d over 1 %%; of those %.3f %% at most is left in 0.00002 degrees; iris's centre unlit at %d angles\n",
                  tested, 100 * worst, steep, 100 * worst_left, outside);
    assert_true(tested > 100000 && outside > 1000);
    assert_int_equal(jumps, 0);
}

/* ---- behaviour ---- */

static void lights_that_draw_nothing(void **state)
{
    lflare_settings s = raw_at(0);
    lflare *flare = open_lens(HELIAR, &s);
    lflare_view view = view_of(96, 54);
    lflare_light light = light_at(0.1, 0.05);
    lflare_image image;
    int i;
    (void)state;
    image = picture(flare, &view, &light, 1);
    assert_true(sum_of(&image) > 0); /* this one does */
    free(image.pixels);
    for (i = 0; i < 8; i++) {
        light = light_at(0.1, 0.05);
        if (i == 1) light.color[0] = light.color[1] = light.color[2] = 0;
        if (i == 2) light.color[0] = light.color[1] = light.color[2] = -1;
        if (i == 3) light.direction[2] = 1; /* behind */
        if (i == 4) light.direction[2] = 0; /* beside */
        if (i == 5) light.occlusion[0] = light.occlusion[1] = light.occlusion[2] = 1;
        if (i == 6) light.flags = LFLARE_LIGHT_NO_GHOSTS;
        if (i == 7) light.direction[0] = light.direction[1] = light.direction[2] = 0;
        image = picture(flare, &view, &light, i == 0 ? 0 : 1);
        assert_true(sum_of(&image) == 0);
        assert_int_equal(lflare_get_frame(flare)->instance_count, 0);
        check_sane(&image, "nothing");
        free(image.pixels);
    }
    assert_int_equal(lflare_frame(flare, &view, NULL, 0), LFLARE_OK); /* none at all needs no array */
    lflare_destroy(flare);
}

/* A light outside the frame has no image in it, but ghosts. */
static void light_outside(void **state)
{
    lflare_settings s = raw_at(4);
    lflare *flare = open_lens(HELIAR, &s);
    lflare_view view = view_of(192, 108);
    lflare_light light = light_at(1.5 * 18 / 99.2358, 0);
    lflare_image image = picture(flare, &view, &light, 1);
    const lflare_frame_data *f = lflare_get_frame(flare);
    (void)state;
    assert_true(fabsf(f->lights[0].image[0]) > 1.4f * f->half_width);
    assert_true(f->instance_count > 0 && sum_of(&image) > 0);
    check_sane(&image, "outside");
    free(image.pixels);
    light = light_at(50, 20); /* 89 degrees */
    image = picture(flare, &view, &light, 1);
    check_sane(&image, "grazing");
    assert_true(sum_of(&image) == 0);
    free(image.pixels);
    lflare_destroy(flare);
}

/* A light that leaves the frame fades over the width asked for, at either side, with the axis off the middle too. */
static void light_leaves_the_frame(void **state)
{
    lflare *flare = open_lens(HELIAR, NULL);
    lflare_view view = view_of(160, 90);
    const lflare_frame_data *frame = lflare_get_frame(flare);
    int side, i;
    (void)state;
    view.fov_y = 1;
    for (side = -1; side <= 1; side += 2) {
        double edge, before = 2;
        view.centre[0] = 0.25f;
        edge = tan(0.5) * 160 / 90 * (side - 0.25); /* tangent of the light's angle at the frame's edge */
        for (i = -10; i <= 30; i++) {
            double beyond = 0.05 * i; /* in half-heights */
            lflare_light light = light_at(edge + side * beyond * tan(0.5), 0);
            double whole, left;
            view.edge_fade = 0;
            assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
            whole = (double)frame->lights[0].irradiance[1];
            view.edge_fade = 0.8f;
            assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
            left = frame->light_count > 0 ? (double)frame->lights[0].irradiance[1] / whole : 0;
            if (beyond <= 0) assert_true(fabs(left - 1) < 1e-5);
            if (i == 8) assert_true(fabs(left - 0.5) < 1e-3); /* half of the width */
            if (beyond >= 0.8) assert_true(left < 1e-5);
            assert_true(left <= before + 1e-6 && before - left < 0.1 + (i == -10 ? 2 : 0));
            before = left;
        }
    }
    view.edge_fade = -1;
    assert_int_equal(lflare_frame(flare, &view, NULL, 0), LFLARE_ERROR_ARGUMENT);
    lflare_destroy(flare);
}

/* Never faster than asked, the same at every frame rate, and it neither overshoots nor sticks. */
static void fades_in_time(void **state)
{
    static const float rates[4] = {24, 60, 144, 1000};
    int r, i;
    (void)state;
    for (r = 0; r < 4; r++) {
        float dt = 1 / rates[r], up = 0, down = 1;
        for (i = 1; i <= (int)rates[r]; i++) {
            float before_up = up, before_down = down;
            double share_up = 1 - exp(-(double)i * (double)dt / 0.3), share_down = exp(-(double)i * (double)dt / 0.05);
            up = lflare_fade(up, 1, dt, 0.3f, 0.05f);
            down = lflare_fade(down, 0, dt, 0.3f, 0.05f);
            assert_true(up > before_up || up == 1);
            assert_true((down < before_down || down == 0) && down >= 0); /* within 1e-5 it is there */
            assert_true(fabs((double)up - share_up) < 1e-4 && fabs((double)down - share_down) < 1e-4);
            assert_true((double)up <= (double)i * (double)dt / 0.3 + 1e-6); /* the slope at the start is the steepest */
        }
    }
    assert_true(lflare_fade(0.3f, 0.8f, 0.01f, 0, 1) == 0.8f);
    assert_true(lflare_fade(0.8f, 0.3f, 0.01f, 1, 0) == 0.3f);
    assert_true(lflare_fade(0.3f, 0.8f, 0, 1, 1) == 0.3f);
    assert_true(lflare_fade(0.3f, 0.8f, -1, 1, 1) == 0.3f);
    assert_true(lflare_fade(0.3f, 0.8f, 1e9f, 1, 1) == 0.8f);
    assert_true(lflare_fade(NAN, 0.8f, 0.01f, 1, 1) == 0.8f);
}

static void not_numbers(void **state)
{
    lflare *flare = open_lens(HELIAR, NULL);
    const float wrong[3] = {(float)NAN, (float)INFINITY, -(float)INFINITY};
    int i, w;
    (void)state;
    for (w = 0; w < 3; w++)
        for (i = 0; i < 13; i++) {
            lflare_view view = view_of(64, 36);
            lflare_light lights[2];
            lflare_image image = image_of(64, 36);
            lights[0] = light_at(0.1, 0.05);
            lights[1] = light_at(0.05, -0.1);
            if (i < 3) lights[1].direction[i] = wrong[w];
            else if (i < 6) lights[1].color[i - 3] = wrong[w];
            else if (i < 9) lights[1].occlusion[i - 6] = wrong[w];
            else if (i == 9) lights[1].angular_radius = wrong[w];
            else if (i == 10) view.fov_y = wrong[w];
            else view.centre[i - 11] = wrong[w];
            if (lflare_frame(flare, &view, lights, 2) != LFLARE_ERROR_ARGUMENT) fail_msg("number %d of kind %d is accepted", i, w);
            assert_int_equal(lflare_get_frame(flare)->instance_count, 0);
            assert_int_equal(lflare_get_frame(flare)->light_count, 0);
            lflare_render(flare, &image); /* whatever it says, it draws nothing */
            assert_true(sum_of(&image) == 0);
            free(image.pixels);
        }
    {
        static const int sizes[4][2] = {{0, 10}, {10, 0}, {-1, 10}, {10, -1}};
        lflare_light light = light_at(0.1, 0.05);
        for (i = 0; i < 4; i++) {
            lflare_view view = view_of(sizes[i][0], sizes[i][1]);
            assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_ERROR_ARGUMENT);
        }
        assert_int_equal(lflare_frame(flare, NULL, &light, 1), LFLARE_ERROR_ARGUMENT);
        assert_int_equal(lflare_frame(flare, NULL, NULL, 1), LFLARE_ERROR_ARGUMENT);
    }
    lflare_destroy(flare);
}

/* Ghost (3,2) of the Heliar, bounded by the round iris alone near the axis, is round in frames of any shape. */
static void round_stays_round(void **state)
{
    static const int sizes[5][2] = {{400, 300}, {480, 270}, {640, 180}, {180, 320}, {200, 200}};
    int i, fit;
    (void)state;
    for (i = 0; i < 5; i++)
        for (fit = 0; fit < 4; fit++) {
            lflare_override none;
            lflare *flare;
            lflare_view view = view_of(sizes[i][0], sizes[i][1]);
            lflare_light light = light_at(0.006, 0.008);
            lflare_image image;
            int x, y, box[4] = {10000, -1, 10000, -1};
            double most = 0, area = 0;
            memset(&none, 0, sizeof none);
            flare = open_solo(HELIAR, 45, 2, none);
            view.fit = (lflare_fit)fit;
            view.fov_y = (float)(2 * atan(sizes[i][0] < sizes[i][1] ? 20 / 99.2358 : 12 / 99.2358));
            light.direction[0] *= fit == 3 ? 1 : 0.5f;
            image = picture(flare, &view, &light, 1);
            for (y = 0; y < view.height; y++)
                for (x = 0; x < view.width; x++) most = fmax(most, (double)image.pixels[(y * view.width + x) * 4 + 1]);
            for (y = 0; y < view.height; y++)
                for (x = 0; x < view.width; x++)
                    if ((double)image.pixels[(y * view.width + x) * 4 + 1] > 0.5 * most) {
                        if (x < box[0]) box[0] = x;
                        if (x > box[1]) box[1] = x;
                        if (y < box[2]) box[2] = y;
                        if (y > box[3]) box[3] = y;
                        area++;
                    }
            assert_true(most > 0);
            assert_true(box[0] > 0 && box[1] < view.width - 1 && box[2] > 0 && box[3] < view.height - 1);
            assert_true(box[1] - box[0] > 20); /* a size that shows */
            if (abs((box[1] - box[0]) - (box[3] - box[2])) > 1) fail_msg("%dx%d, fit %d: %d by %d pixels", view.width, view.height, fit, box[1] - box[0] + 1, box[3] - box[2] + 1);
            assert_true(fabs(area / (PI / 4 * (box[1] - box[0] + 1) * (box[3] - box[2] + 1)) - 1) < 0.1); /* a square: 1.27 */
            free(image.pixels);
            lflare_destroy(flare);
        }
}

static void always_sane(void **state)
{
    static const double fnumbers[6] = {1.4, 2.8, 5.6, 11, 22, 64};
    int l, f, a;
    (void)state;
    for (l = 0; l < lenses.count; l += 3) { /* a starburst for each f-number takes its time */
        lflare *flare = open_lens(lenses.path[l], NULL);
        for (f = 0; f < 6; f++) {
            lflare_settings s;
            memset(&s, 0, sizeof s);
            s.fnumber = fnumbers[f];
            s.blades = f % 3 == 0 ? 0 : 4 + f;
            s.blade_curvature = f % 2 ? 0.5f : 0;
            assert_int_equal(lflare_configure(flare, &s, NULL), LFLARE_OK);
            for (a = 0; a < 7; a++) {
                lflare_view view = view_of(a == 5 ? 27 : 96, a == 5 ? 96 : 54);
                lflare_light lights[2];
                lflare_image image;
                lights[0] = light_at(tan(a * a * PI / 180), 0.3 * tan(a * 4 * PI / 180));
                lights[1] = light_at(-0.02 * a, 0.01);
                lights[0].angular_radius = a % 2 ? 0.00465f : 0;
                image = picture(flare, &view, lights, 2);
                check_sane(&image, lenses.path[l]);
                free(image.pixels);
            }
        }
        lflare_destroy(flare);
    }
}

static lflare *standard(lflare_view *view, lflare_light *lights)
{
    lflare_settings s = raw_at(5.6);
    lflare *flare;
    s.blades = 6;
    flare = open_lens(CANON, &s);
    *view = view_of(150, 85);
    lights[0] = light_at(0.13, 0.07);
    lights[0].angular_radius = 0.00465f;
    lights[1] = light_at(-0.2, 0.02);
    lights[1].color[1] = 0.5f;
    return flare;
}

/* A view inside a larger target: its pixels are those of the view alone, all others are left as they were. */
static void view_in_target(void **state)
{
    enum { W = 211, H = 120, X = 40, Y = 20 };
    lflare_view view;
    lflare_light lights[2];
    lflare *flare = standard(&view, lights);
    lflare_image alone = picture(flare, &view, lights, 2), target = image_of(W, H), part = alone;
    size_t i, count = floats_of(&target);
    int x, y, k;
    (void)state;
    for (i = 0; i < count; i++) target.pixels[i] = -7;
    for (y = 0; y < view.height; y++)
        for (x = 0; x < view.width * 4; x++) target.pixels[((y + Y) * W + X) * 4 + x] = 0;
    part.pixels = target.pixels + (Y * W + X) * 4;
    part.stride = W * 4;
    assert_int_equal(lflare_render(flare, &part), LFLARE_OK);
    for (y = 0; y < H; y++)
        for (x = 0; x < W; x++)
            for (k = 0; k < 4; k++) {
                float v = target.pixels[(y * W + x) * 4 + k];
                if (x < X || x >= X + view.width || y < Y || y >= Y + view.height) assert_true(v == -7);
                else assert_true(v == (k == 3 ? 0 : alone.pixels[((y - Y) * view.width + x - X) * 4 + k]));
            }
    part.width--; /* not the view's size */
    assert_int_equal(lflare_render(flare, &part), LFLARE_ERROR_ARGUMENT);
    free(alone.pixels);
    free(target.pixels);
    lflare_destroy(flare);
}

static void bottom_up_mirrors(void **state)
{
    lflare_view view;
    lflare_light lights[2];
    lflare *flare = standard(&view, lights);
    lflare_image down = picture(flare, &view, lights, 2), up = image_of(view.width, view.height);
    size_t row = (size_t)view.width * 4;
    int y;
    (void)state;
    up.bottom_up = 1;
    assert_int_equal(lflare_render(flare, &up), LFLARE_OK);
    for (y = 0; y < view.height; y++)
        assert_memory_equal(down.pixels + row * (size_t)y, up.pixels + row * (size_t)(view.height - 1 - y), row * sizeof(float));
    assert_false(same(&down, &up));
    free(down.pixels);
    free(up.pixels);
    lflare_destroy(flare);
}

/* Rows drawn in pieces and in any order are the whole picture, to the bit; so is the picture drawn again. */
static void pieces_and_repeats(void **state)
{
    static const int cuts[5][2] = {{60, 85}, {0, 1}, {1, 33}, {33, 60}, {85, 85}};
    lflare_view view;
    lflare_light lights[2];
    lflare *flare = standard(&view, lights), *other;
    lflare_image whole = picture(flare, &view, lights, 2), pieces = image_of(view.width, view.height), again, elsewhere;
    int i;
    (void)state;
    assert_int_equal(lflare_render_begin(flare), LFLARE_OK);
    for (i = 0; i < 5; i++) assert_int_equal(lflare_render_rows(flare, &pieces, cuts[i][0], cuts[i][1]), LFLARE_OK);
    assert_true(sum_of(&whole) > 0);
    assert_true(same(&whole, &pieces));
    again = picture(flare, &view, lights, 2);
    assert_true(same(&whole, &again));
    other = standard(&view, lights); /* another object */
    elsewhere = picture(other, &view, lights, 2);
    assert_true(same(&whole, &elsewhere));
    lflare_destroy(other);
    {   /* configured in steps: the same tables */
        lflare_settings s = raw_at(2.8);
        lflare_image open_picture, stepped;
        assert_int_equal(lflare_configure(flare, &s, NULL), LFLARE_OK);
        open_picture = picture(flare, &view, lights, 2);
        assert_false(same(&whole, &open_picture));
        s.fnumber = 5.6;
        s.blades = 6;
        assert_int_equal(lflare_configure_begin(flare, &s, NULL), LFLARE_OK);
        for (i = 0; lflare_configure_step(flare, 10) == LFLARE_INCOMPLETE; i++) { /* frames use the old tables until then */
            stepped = picture(flare, &view, lights, 2);
            assert_true(same(&open_picture, &stepped));
            free(stepped.pixels);
        }
        assert_int_equal(i, 17); /* 171 ghosts */
        stepped = picture(flare, &view, lights, 2);
        assert_true(same(&whole, &stepped));
        free(stepped.pixels);
        free(open_picture.pixels);
    }
    free(whole.pixels);
    free(pieces.pixels);
    free(again.pixels);
    free(elsewhere.pixels);
    lflare_destroy(flare);
}

static void adds_to_what_is_there(void **state)
{
    lflare_view view;
    lflare_light lights[2];
    lflare *flare = standard(&view, lights);
    lflare_image black = picture(flare, &view, lights, 2), grey = image_of(view.width, view.height), one, two;
    size_t i, count = floats_of(&black);
    double worst = 0, most = 0;
    (void)state;
    for (i = 0; i < count; i++) grey.pixels[i] = 0.125f;
    assert_int_equal(lflare_render(flare, &grey), LFLARE_OK);
    for (i = 0; i < count; i++) {
        if (i % 4 == 3) {
            assert_true(grey.pixels[i] == 0.125f && black.pixels[i] == 0.25f);
            continue;
        }
        worst = fmax(worst, fabs((double)grey.pixels[i] - 0.125 - (double)black.pixels[i]));
        most = fmax(most, (double)black.pixels[i]);
    }
    assert_true(most > 0 && worst < 1e-6 * (0.125 + most));
    one = picture(flare, &view, lights, 1); /* two lights are the sum of either */
    two = picture(flare, &view, lights + 1, 1);
    for (i = 0; i < count; i++)
        if (i % 4 != 3) assert_true(fabs((double)one.pixels[i] + (double)two.pixels[i] - (double)black.pixels[i]) < 1e-5 * most);
    assert_true(sum_of(&one) > 0 && sum_of(&two) > 0);
    free(one.pixels);
    free(two.pixels);
    free(black.pixels);
    free(grey.pixels);
    lflare_destroy(flare);
}

/* The light in each channel and its middle, in pixels from the centre, x right and y up. */
static void moments(const lflare_image *image, double *sum, double *at)
{
    int x, y, k;
    double mx = 0, my = 0, all = 0;
    sum[0] = sum[1] = sum[2] = 0;
    for (y = 0; y < image->height; y++)
        for (x = 0; x < image->width; x++)
            for (k = 0; k < 3; k++) {
                double v = (double)image->pixels[(y * image->width + x) * 4 + k];
                sum[k] += v;
                all += v;
                mx += v * (x + 0.5 - 0.5 * image->width);
                my += v * (0.5 * image->height - 0.5 - y);
            }
    at[0] = mx / all;
    at[1] = my / all;
}

static void overrides(void **state)
{
    enum { GHOST = 2 }; /* (3,2) */
    lflare_view view = view_of(240, 240);
    lflare_light light = light_at(0.03, 0.04);
    lflare_override change;
    double sum[3], at[2], sum2[3], at2[2], pixel, own[2];
    lflare_image plain, image;
    lflare *flare;
    int k;
    (void)state;
    memset(&change, 0, sizeof change);
    flare = open_solo(HELIAR, 16, GHOST, change);
    assert_int_equal(lflare_get_tables(flare)->active_count, 1); /* hidden ghosts cost nothing */
    plain = picture(flare, &view, &light, 1);
    pixel = (double)lflare_get_frame(flare)->pixel;
    for (k = 0; k < 2; k++) own[k] = -(double)lflare_get_frame(flare)->lights[0].image[k] / pixel;
    moments(&plain, sum, at);
    assert_true(sum[0] > 0 && sum[1] > 0 && sum[2] > 0);
    lflare_destroy(flare);

    change.tint[0] = 0.5f; /* tint and ev */
    change.tint[1] = 2;
    change.ev = 1;
    flare = open_solo(HELIAR, 16, GHOST, change);
    image = picture(flare, &view, &light, 1);
    moments(&image, sum2, at2);
    assert_true(fabs(sum2[0] / sum[0] - 1) < 1e-5 && fabs(sum2[1] / sum[1] - 4) < 1e-4 && sum2[2] == 0);
    free(image.pixels);
    lflare_destroy(flare);

    memset(&change, 0, sizeof change); /* scale: size about the centroid, irradiance kept */
    change.scale = 1.5f;
    flare = open_solo(HELIAR, 16, GHOST, change);
    image = picture(flare, &view, &light, 1);
    moments(&image, sum2, at2);
    for (k = 0; k < 3; k++) assert_true(fabs(sum2[k] / sum[k] / 2.25 - 1) < 0.005);
    assert_true(hypot(at2[0] - at[0], at2[1] - at[1]) < 0.05);
    {
        double before = (double)plain.pixels[((int)(120 - at[1]) * 240 + (int)(120 + at[0])) * 4 + 1];
        double after = (double)image.pixels[((int)(120 - at[1]) * 240 + (int)(120 + at[0])) * 4 + 1];
        assert_true(before > 0 && fabs(after / before - 1) < 0.002);
    }
    free(image.pixels);
    lflare_destroy(flare);

    memset(&change, 0, sizeof change); /* move: along the line to the light, and to the left of it */
    change.move[0] = 0.25f;
    change.move[1] = 0.5f;
    flare = open_solo(HELIAR, 16, GHOST, change);
    image = picture(flare, &view, &light, 1);
    moments(&image, sum2, at2);
    for (k = 0; k < 3; k++) assert_true(fabs(sum2[k] / sum[k] - 1) < 0.002);
    if (!(fabs(at2[0] - at[0] - (0.25 * own[0] - 0.5 * own[1])) < 0.05 && fabs(at2[1] - at[1] - (0.25 * own[1] + 0.5 * own[0])) < 0.05))
        fail_msg("moved by %g %g pixels, the light is at %g %g", at2[0] - at[0], at2[1] - at[1], own[0], own[1]);
    free(image.pixels);
    lflare_destroy(flare);

    memset(&change, 0, sizeof change); /* hide */
    change.hide = 1;
    flare = open_solo(HELIAR, 16, GHOST, change);
    image = picture(flare, &view, &light, 1);
    assert_true(sum_of(&image) == 0);
    free(image.pixels);
    {   /* of a ghost that there is not; overrides may then be forgotten by the caller */
        lflare_settings s = raw_at(16);
        lflare_override none;
        lflare_error error;
        memset(&none, 0, sizeof none);
        none.first = 5;
        none.second = 5;
        s.overrides = &none;
        s.override_count = 1;
        assert_int_equal(lflare_configure(flare, &s, &error), LFLARE_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, "(5,5)"));
        image = picture(flare, &view, &light, 1); /* the old settings hold */
        assert_true(sum_of(&image) == 0);
        free(image.pixels);
    }
    lflare_destroy(flare);
    free(plain.pixels);
}

/* At most so many ghosts a light, each light by itself, and the strongest ones of those that can be seen. */
static void budget(void **state)
{
    static const int budgets[4] = {1, 5, 20, 1000};
    lflare_view view;
    lflare_light lights[2];
    lflare *flare = standard(&view, lights);
    const lflare_frame_data *f = lflare_get_frame(flare);
    int32_t all[2] = {0, 0}, i, b;
    double whole, before = 0;
    lflare_image image = picture(flare, &view, lights, 2);
    (void)state;
    whole = sum_of(&image);
    free(image.pixels);
    for (i = 0; i < f->instance_count; i++) all[f->instances[i].light]++;
    assert_true(all[0] > 20 && all[1] > 20);
    for (b = 0; b < 4; b++) {
        lflare_settings s = raw_at(5.6);
        int32_t used[2] = {0, 0};
        double sum;
        s.blades = 6;
        s.ghost_budget = budgets[b];
        assert_int_equal(lflare_configure(flare, &s, NULL), LFLARE_OK);
        image = picture(flare, &view, lights, 2);
        sum = sum_of(&image);
        free(image.pixels);
        for (i = 0; i < f->instance_count; i++) used[f->instances[i].light]++;
        for (i = 0; i < 2; i++) assert_int_equal(used[i], budgets[b] < all[i] ? budgets[b] : all[i]);
        assert_true(sum > before && sum < whole * 1.000001);
        before = sum;
    }
    assert_true(fabs(before / whole - 1) < 1e-9);
    lflare_destroy(flare);
}

/* A ramp multiplies the tint at the light's field angle: before its first stop, between two, beyond the last. */
static void ramps(void **state)
{
    static const double angles[3] = {0.01, 0.0375, 0.06}; /* along x */
    static const double expected[3][3] = {{2, 1, 0}, {1.25, 1, 1.5}, {0.5, 1, 3}};
    lflare_view view = view_of(160, 120);
    lflare_override change;
    lflare *plain, *flare;
    int i, k;
    (void)state;
    memset(&change, 0, sizeof change);
    plain = open_solo(HELIAR, 16, 2, change);
    change.ramp_count = 2;
    change.ramp[0].rgb[0] = 2;
    change.ramp[0].rgb[1] = change.ramp[1].rgb[1] = 1;
    change.ramp[0].rgb[2] = -5; /* counts as 0 */
    change.ramp[0].angle = 0.025f;
    change.ramp[1].rgb[0] = 0.5f;
    change.ramp[1].rgb[2] = 3;
    change.ramp[1].angle = 0.05f;
    flare = open_solo(HELIAR, 16, 2, change);
    for (i = 0; i < 3; i++) {
        lflare_light light = light_at(tan(angles[i]), 0);
        lflare_image a = picture(plain, &view, &light, 1), b = picture(flare, &view, &light, 1);
        double sum[3], at[2], sum2[3];
        moments(&a, sum, at);
        moments(&b, sum2, at);
        for (k = 0; k < 3; k++)
            if (!(fabs(sum2[k] / sum[k] - expected[i][k]) < 1e-3)) fail_msg("light %d, channel %d: %g", i, k, sum2[k] / sum[k]);
        free(a.pixels);
        free(b.pixels);
    }
    lflare_destroy(plain);
    lflare_destroy(flare);
}

/* Elements off the axis move a ghost by a constant, wherever the light is; the same seed is the same lens. */
static void imperfections(void **state)
{
    lflare_view view = view_of(320, 240);
    lflare *flare;
    double first[2] = {0, 0};
    float style[2][2];
    int seed, i;
    (void)state;
    for (seed = 0; seed < 3; seed++) {
        lflare_settings s = raw_at(16);
        const lflare_tables *t;
        int32_t count;
        lflare_override none, *hidden;
        memset(&none, 0, sizeof none);
        flare = open_solo(HELIAR, 16, 2, none);
        hidden = all_but(lflare_get_tables(flare), 2, &count);
        s.overrides = hidden;
        s.override_count = count;
        for (i = 0; i < 2; i++) {
            lflare_light light = light_at(0.04 * i, 0.01 * i);
            double sum[3], at[2], moved[2];
            lflare_image image;
            s.imperfection = 0;
            assert_int_equal(lflare_configure(flare, &s, NULL), LFLARE_OK);
            image = picture(flare, &view, &light, 1);
            moments(&image, sum, at);
            free(image.pixels);
            s.imperfection = 0.05f;
            s.imperfection_seed = (uint32_t)seed / 2;
            assert_int_equal(lflare_configure(flare, &s, NULL), LFLARE_OK);
            t = lflare_get_tables(flare);
            image = picture(flare, &view, &light, 1);
            moments(&image, sum, moved);
            free(image.pixels);
            moved[0] -= at[0];
            moved[1] -= at[1];
            if (i == 0) memcpy(first, moved, sizeof first);
            assert_true(hypot(moved[0], moved[1]) > 0.5 && hypot(moved[0] - first[0], moved[1] - first[1]) < 0.05); /* pixels */
            if (seed == 0) memcpy(style[0], t->style + 2 * LFLARE_STYLE_FLOATS + 8, sizeof style[0]);
            memcpy(style[1], t->style + 2 * LFLARE_STYLE_FLOATS + 8, sizeof style[1]);
            assert_int_equal(memcmp(style[0], style[1], sizeof style[0]) == 0, seed < 2);
        }
        free(hidden);
        lflare_destroy(flare);
    }
}

/* Refused, and the old settings hold. */
static void settings_out_of_range(void **state)
{
    lflare *flare;
    lflare_override none;
    lflare_error error;
    int i;
    (void)state;
    memset(&none, 0, sizeof none);
    flare = open_solo(HELIAR, 16, 2, none);
    none.first = lflare_get_tables(flare)->pairs[0].first + 1;
    none.second = lflare_get_tables(flare)->pairs[0].second + 1;
    for (i = 0; i < 9; i++) {
        lflare_settings s = raw_at(8);
        lflare_override change = none;
        s.overrides = &change;
        s.override_count = 1;
        if (i == 0) s.vertex_budget = -1;
        if (i == 1) s.pixel_budget = -1;
        if (i == 2) s.imperfection = -0.01f;
        if (i == 3) s.imperfection = 0.2f;
        if (i == 4) s.imperfection = (float)NAN;
        if (i == 5) change.ramp_count = LFLARE_RAMP_STOPS + 1;
        if (i == 6) change.ramp_count = -1;
        if (i == 7) change.ramp_count = 2; /* angles do not rise */
        if (i == 8) {
            change.ramp_count = 1;
            change.ramp[0].rgb[1] = (float)NAN;
        }
        assert_int_equal(lflare_configure(flare, &s, &error), LFLARE_ERROR_ARGUMENT);
        assert_true(error.text[0] != 0);
    }
    lflare_destroy(flare);
}

/* Lights share budgets of pixels by brightness, what one does not need goes to the others; a slow light makes no ghost pop. */
static void budgets_are_shared(void **state)
{
    lflare_view view;
    lflare_light lights[2];
    lflare *flare = standard(&view, lights);
    lflare_tables t = *lflare_get_tables(flare);
    lflare_frame_data f;
    int32_t all, used[2], i, b, step;
    (void)state;
    assert_int_equal(lflare_frame(flare, &view, lights, 2), LFLARE_OK);
    f = *lflare_get_frame(flare);
    all = f.instance_count;
    t.vertex_budget = 52 * all * 3; /* enough for all, three times: none fades */
    assert_int_equal(lflare_frame_build(&t, &view, lights, 2, &f), LFLARE_OK);
    assert_int_equal(f.instance_count, all);
    for (i = 0; i < f.instance_count; i++) assert_int_equal(f.instances[i].band, 0);
    for (b = 0; b < 2; b++) {
        used[0] = used[1] = 0;
        t.vertex_budget = 52 * 21;
        for (i = 0; i < 3; i++) {
            lights[0].color[i] = 1;
            lights[1].color[i] = b == 0 ? 1 : 1e-3f;
        }
        assert_int_equal(lflare_frame_build(&t, &view, lights, 2, &f), LFLARE_OK);
        for (i = 0; i < f.instance_count; i++) used[f.instances[i].light]++;
        if (b == 0) assert_true(abs(used[0] - used[1]) <= 1 && used[0] + used[1] >= 20);
        else assert_true(used[0] >= 20 && used[1] == 0);
    }
    t.vertex_budget = 0;
    t.pixel_budget = 20000;
    {
        double before = -1, jump = 0, most = 0;
        for (step = 0; step < 400; step++) { /* intensities given up, each ghost's share of the light weighed by its rank */
            double sum = 0;
            lights[0].direction[0] = 0.05f + 0.0001f * (float)step;
            lights[0].direction[1] = 0.02f;
            assert_int_equal(lflare_frame_build(&t, &view, lights, 1, &f), LFLARE_OK);
            for (i = 0; i < f.instance_count; i++) sum += (double)t.rank[2 * f.instances[i].ghost] * (1 - (f.instances[i].band >> 10) / 63.0);
            if (before >= 0) jump = fmax(jump, fabs(sum - before));
            most = fmax(most, sum);
            before = sum;
        }
        print_message("budget of 20000 pixels: what is drawn changes by at most %.4f of it from one of 400 places to the next\n", jump / most);
        assert_true(jump < 0.02 * most);
    }
    lflare_destroy(flare);
}

static void odd_stops_render(void **state)
{
    static const char *odd[2] = {"lensflare 1\nfnumber 8\nstop 5\n50 4 n 1.6\n-80 3\n70 4 n 1.7\n-300 focus\n",
                                 "lensflare 1\nfnumber 8\n50 4 n 1.6\n-80 3\n70 4 n 1.7\n-300 5\nstop focus\n"};
    int i, a;
    (void)state;
    for (i = 0; i < 2; i++) {
        lflare_settings s = raw_at(0);
        lflare *flare = open_text(odd[i], &s);
        double most = 0;
        assert_int_equal(lflare_get_tables(flare)->ghost_count, 6);
        for (a = 0; a < 30; a += 3) {
            lflare_view view = view_of(90, 60);
            lflare_light light = light_at(tan(a * PI / 180), 0.01);
            lflare_image image = picture(flare, &view, &light, 1);
            check_sane(&image, odd[i]);
            most = fmax(most, sum_of(&image));
            free(image.pixels);
        }
        assert_true(most > 0);
        lflare_destroy(flare);
    }
}

/* Half hidden is half the light, per channel; so is half the colour, and a stop of exposure doubles. */
static void light_is_linear(void **state)
{
    lflare_view view;
    lflare_light lights[2];
    lflare *flare = standard(&view, lights);
    lflare_image full = picture(flare, &view, lights, 1), half, doubled;
    lflare_settings s = raw_at(5.6);
    size_t i, count = floats_of(&full);
    double most = 0;
    (void)state;
    for (i = 0; i < count; i++)
        if (i % 4 != 3) most = fmax(most, (double)full.pixels[i]);
    lights[0].occlusion[0] = 0.5f;
    lights[0].occlusion[2] = 0.75f;
    lights[0].color[2] = 2;
    half = picture(flare, &view, lights, 1);
    s.blades = 6;
    s.exposure_ev = 1;
    lights[0].occlusion[0] = lights[0].occlusion[2] = 0;
    lights[0].color[2] = 1;
    assert_int_equal(lflare_configure(flare, &s, NULL), LFLARE_OK);
    doubled = picture(flare, &view, lights, 1);
    for (i = 0; i < count; i++)
        if (i % 4 != 3) {
            double v = (double)full.pixels[i];
            assert_true(fabs((double)half.pixels[i] - (i % 4 == 1 ? 1 : 0.5) * v) < 1e-6 * most);
            assert_true(fabs((double)doubled.pixels[i] - 2 * v) < 1e-6 * most);
        }
    free(full.pixels);
    free(half.pixels);
    free(doubled.pixels);
    lflare_destroy(flare);
}

static double place_of_image(const lflare *flare) /* in half-widths */
{
    const lflare_frame_data *f = lflare_get_frame(flare);
    return ((double)f->centre[0] - (double)f->lights[0].image[0]) / (double)f->half_width;
}

/* A squeezed view shows what one with square pixels and as many times fewer columns shows of the light where the attachment puts it. */
static void squeezed(void **state)
{
    enum { W = 640, H = 360 };
    static const float bad[3] = {-1, 100, (float)NAN};
    lflare_settings settings = raw_at(8);
    lflare *flare;
    lflare_view view = view_of(W, H), half = view_of(W / 2, H);
    lflare_light light = light_at(0.12, 0.06), seen = light_at(0.06, 0.06);
    lflare_image wide, narrow;
    double apart = 0, all = 0, place;
    int i;
    (void)state;
    settings.blades = 6;
    flare = open_lens(HELIAR, &settings);
    view.fit = half.fit = LFLARE_FIT_HEIGHT;
    view.squeeze = 2;
    wide = picture(flare, &view, &light, 1);
    place = place_of_image(flare);
    narrow = picture(flare, &half, &seen, 1);
    for (i = 0; i < W / 2 * H; i++) {
        double a = 0.5 * (double)(wide.pixels[8 * i + 1] + wide.pixels[8 * i + 5]), b = (double)narrow.pixels[4 * i + 1];
        apart += (a - b) * (a - b);
        all += b * b;
    }
    if (!(apart < 1e-3 * all)) fail_msg("squeezed and narrow are %.2g apart", sqrt(apart / all)); /* edges are a pixel wide, which differs */
    view.squeeze = 0;
    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
    assert_true(fabs(place / place_of_image(flare) - 1) < 1e-5); /* the light stays where it is */
    for (i = 0; i < 3; i++) {
        view.squeeze = bad[i];
        assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_ERROR_ARGUMENT);
    }
    free(wide.pixels);
    free(narrow.pixels);
    lflare_destroy(flare);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orientation),
        cmocka_unit_test(true_slopes),
        cmocka_unit_test(kept_rims),
        cmocka_unit_test(energy_plain),
        cmocka_unit_test(energy_open),
        cmocka_unit_test(energy_tiny),
        cmocka_unit_test(energy_sun),
        cmocka_unit_test(energy_lamp),
        cmocka_unit_test(energy_rims),
        cmocka_unit_test(energy_pentagon),
        cmocka_unit_test(colour_continuous),
        cmocka_unit_test(lights_that_draw_nothing),
        cmocka_unit_test(light_outside),
        cmocka_unit_test(light_leaves_the_frame),
        cmocka_unit_test(fades_in_time),
        cmocka_unit_test(not_numbers),
        cmocka_unit_test(round_stays_round),
        cmocka_unit_test(always_sane),
        cmocka_unit_test(view_in_target),
        cmocka_unit_test(bottom_up_mirrors),
        cmocka_unit_test(pieces_and_repeats),
        cmocka_unit_test(adds_to_what_is_there),
        cmocka_unit_test(overrides),
        cmocka_unit_test(budget),
        cmocka_unit_test(ramps),
        cmocka_unit_test(imperfections),
        cmocka_unit_test(settings_out_of_range),
        cmocka_unit_test(budgets_are_shared),
        cmocka_unit_test(odd_stops_render),
        cmocka_unit_test(light_is_linear),
        cmocka_unit_test(squeezed),
    };
    return cmocka_run_group_tests(tests, setup, NULL);
}
