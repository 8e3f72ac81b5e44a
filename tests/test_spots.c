/* What lensopt.h says a lens shows, against the pictures that lensflare.h draws of it. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#define LENSOPT_IMPLEMENTATION
#include "lensopt.h"

enum { W = 480, H = 320, GHOSTS = 400 };

static lflare *open_lens(const char *path, double fnumber)
{
    lflare_desc desc;
    lflare_error error;
    lflare *flare;
    char *text;
    memset(&desc, 0, sizeof desc);
    assert_int_equal(lflare_file_read(path, NULL, NULL, &text, &desc.text_size, &error), LFLARE_OK);
    desc.text = text;
    desc.settings.fnumber = fnumber;
    desc.settings.raw = desc.settings.no_starburst = desc.settings.no_ringing = 1;
    desc.settings.model = LFLARE_MODEL_PARAXIAL;
    assert_int_equal(lflare_create(&desc, &flare, &error), LFLARE_OK);
    free(text);
    return flare;
}

/* Flux, mean place and radius (a disc's, of the same second moment) of one ghost's picture, in mm; the light lies in the picture's upper half. */
static void picture_of(lflare *flare, int32_t ghost, double u, double *flux, double *place, double *radius)
{
    const lflare_frame_data *frame = lflare_get_frame(flare);
    lflare_view view;
    lflare_light light;
    lflare_image image;
    double sum = 0, at = 0, spread = 0, mm;
    int32_t i;
    memset(&view, 0, sizeof view);
    memset(&light, 0, sizeof light);
    memset(&image, 0, sizeof image);
    view.width = image.width = W;
    view.height = image.height = H;
    light.direction[1] = (float)u;
    light.direction[2] = -1;
    for (i = 0; i < 3; i++) light.color[i] = 1;
    image.pixels = (float *)calloc((size_t)W * H, 4 * sizeof(float));
    assert_int_equal(lflare_frame(flare, &view, &light, 1), LFLARE_OK);
    mm = 2 * (double)frame->half_width / W;
    for (i = 0; i < frame->instance_count; i++) {
        lflare_footprint fp;
        if (frame->instances[i].ghost != ghost || !lflare_footprint_resolve(lflare_get_tables(flare), frame, frame->instances[i], &fp)) continue;
        assert_int_equal(lflare_software_rows(&fp, 1, &lflare_get_tables(flare)->iris, frame, &image, 0, H), LFLARE_OK);
    }
    for (i = 0; i < W * H; i++) {
        double v = (double)image.pixels[4 * i + 1], y = (0.5 * (H - 1) - i / W) * mm;
        sum += v;
        at += v * y;
        spread += v * y * y;
    }
    *flux = sum * mm * mm;
    *place = sum > 0 ? at / sum : 0;
    *radius = sum > 0 ? 2 * sqrt(fmax(spread / sum - *place * *place - mm * mm / 12, 0)) : 0;
    free(image.pixels);
}

/* Whether a ghost is the whole iris's image, and that larger than what diffraction, which grows its picture, makes of a point. */
static int is_disc(const lflare *flare, lflare_pair pair, const lensopt_spot *s)
{
    lflare_ghost_matrices m;
    double entrance = 0;
    assert_int_equal(lflare_ghost_optics(lflare_get_lens(flare), lensopt__nm[1], &pair, 1, &m), LFLARE_OK);
    entrance = (double)lflare_get_tables(flare)->iris.radius / fabs(m.ma.a);
    return fabs(s->radius / (entrance * fabs(m.m.a)) - 1) < 1e-3 && 0.61e-6 * lensopt__nm[1] * fabs(m.m.b) / entrance < 0.5 * s->radius;
}

/* Every ghost that lies in the frame as a whole: where it is, how large, how bright. */
static void spots_are_seen(void **state)
{
    static const char *const paths[3] = {"lenses/heliar-tronnier.lens", "lenses/nikon-80-200-mid.lens", "lenses/canon-28-80.lens"};
    static const double slopes[3] = {0.03, 0.1, 0.2};
    static lflare_pair pairs[GHOSTS];
    static lensopt_spot spots[GHOSTS];
    int32_t l, a, g, count, seen = 0;
    double apart[3] = {0, 0, 0};
    (void)state;
    for (l = 0; l < 3; l++) {
        lflare *flare = open_lens(paths[l], 8);
        count = GHOSTS;
        assert_int_equal(lflare_ghost_list(lflare_get_lens(flare), pairs, &count), LFLARE_OK);
        for (a = 0; a < 3; a++) {
            assert_int_equal(lensopt_spots(lflare_get_lens(flare), pairs, count, slopes[a], (double)lflare_get_tables(flare)->iris.radius, spots), LFLARE_OK);
            for (g = 0; g < count; g++) {
                const lensopt_spot *s = &spots[g];
                double flux, place, radius, whole = LENSOPT__PI * s->radius * s->radius;
                assert_true(s->radius >= 0 && (s->radius > 0) == (s->clip != LFLARE_CLIP_HIDDEN));
                if (s->radius < 0.5 || fabs(s->centre) + 1.2 * s->radius > 11.9 || !is_disc(flare, pairs[g], s)) continue;
                picture_of(flare, g, slopes[a], &flux, &place, &radius);
                apart[0] = fmax(apart[0], fabs(place - s->centre));
                apart[1] = fmax(apart[1], fabs(radius / s->radius - 1));
                apart[2] = fmax(apart[2], fabs(flux / (s->irradiance[1] * whole) - 1));
                seen++;
            }
        }
        lflare_destroy(flare);
    }
    print_message("%d ghosts: places within %.4f mm, radii within %.2f %%, flux within %.2f %%\n", (int)seen, apart[0], 100 * apart[1], 100 * apart[2]);
    assert_true(seen > 100);
    assert_true(apart[0] < 0.001);
    assert_true(apart[1] < 0.005);
    assert_true(apart[2] < 0.005);
}

static void arguments_are_checked(void **state)
{
    lflare *flare = open_lens("lenses/heliar-tronnier.lens", 0);
    lflare_pair pair = {3, 2, 0, 0};
    lensopt_spot spot;
    (void)state;
    assert_int_equal(lensopt_spots(NULL, &pair, 1, 0, 5, &spot), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_spots(lflare_get_lens(flare), NULL, 1, 0, 5, &spot), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_spots(lflare_get_lens(flare), &pair, 1, 0, 5, NULL), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_spots(lflare_get_lens(flare), &pair, -1, 0, 5, &spot), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_spots(lflare_get_lens(flare), &pair, 1, -0.1, 5, &spot), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_spots(lflare_get_lens(flare), &pair, 1, (double)NAN, 5, &spot), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_spots(lflare_get_lens(flare), &pair, 1, 0, 0, &spot), LFLARE_ERROR_ARGUMENT);
    pair.first = 99;
    assert_int_equal(lensopt_spots(lflare_get_lens(flare), &pair, 1, 0, 5, &spot), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_spots(lflare_get_lens(flare), NULL, 0, 0, 5, NULL), LFLARE_OK);
    lflare_destroy(flare);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {cmocka_unit_test(spots_are_seen), cmocka_unit_test(arguments_are_checked)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
