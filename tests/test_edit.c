/* What lensopt.h does to a lens and to the colours of its ghosts, against rays traced here, lenses derived anew and full paths. */
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

enum { GHOSTS = 1000, LENSES = 6 };

static const char *const paths[LENSES] = {"lenses/heliar-tronnier.lens", "lenses/nikon-80-200-mid.lens", "lenses/canon-28-80.lens", "lenses/distagon-25.lens",
                                          "lenses/tessar-50-35.lens", "lenses/fisheye-nikkor-16.lens"};

static const double nm_d = 587.5618, channels[3] = {650, 510, 475};

#define assert_near(a, b, tolerance) near_to((a), (b), (tolerance), __LINE__)
static void near_to(double a, double b, double tolerance, int line)
{
    if (!(fabs(a - b) <= tolerance)) fail_msg("line %d: %.17g is not %.17g", line, a, b);
}

static void read_lens(const char *path, lflare_prescription *p, lflare_lens *lens)
{
    lflare_error error;
    char *text;
    size_t size;
    assert_int_equal(lflare_file_read(path, NULL, NULL, &text, &size, &error), LFLARE_OK);
    assert_int_equal(lflare_text_read(text, size, p, &error), LFLARE_OK);
    assert_int_equal(lflare_lens_derive(p, lens, &error), LFLARE_OK);
    free(text);
}

static void derive(const lflare_prescription *p, lflare_lens *lens)
{
    lflare_error error;
    if (lflare_lens_derive(p, lens, &error) != LFLARE_OK) fail_msg("%s", error.text);
}

static double iris_of(const lflare_lens *lens) { return fabs(lens->stop_a11) * lens->efl / (2 * lens->fnumber); }

static double index_behind(const lflare_prescription *p, int32_t row, double nm)
{
    while (row >= 0 && p->surfaces[row].is_stop) row--;
    return row < 0 ? 1 : lflare_index(&p->surfaces[row].medium, nm);
}

/* A paraxial ray by the textbook's n u' = n u - y power, at the d line: its height at every row and at the sensor. */
static double trace(const lflare_prescription *p, double y, double slope, double *heights)
{
    int32_t i;
    double n = 1;
    for (i = 0; i < p->surface_count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        double behind = index_behind(p, i, nm_d), curvature = (s->radius != 0 ? 1 / s->radius : 0) + 2 * s->aspheric[0];
        heights[i] = y;
        slope = (n * slope - y * (behind - n) * curvature) / behind;
        n = behind;
        y += slope * s->thickness;
    }
    return y;
}

static int refused(lflare_result result, lflare_result expected, const lflare_error *error, const char *word)
{
    if (result == expected && error->code == expected && strstr(error->text, word) != NULL) return 1;
    print_message("%d, not %d: %s\n", (int)result, (int)expected, error->text);
    return 0;
}

/* ---- resizing ---- */

static void stops_are_resized(void **state)
{
    static lflare_prescription p, q;
    static lflare_lens lens, small;
    static lflare_pair pairs[GHOSTS];
    static lensopt_spot was[GHOSTS], is[GHOSTS];
    int32_t l, g, i, count, seen = 0;
    lflare_error error;
    (void)state;
    for (l = 0; l < LENSES; l++) {
        read_lens(paths[l], &p, &lens);
        q = p;
        assert_int_equal(lensopt_resize_stop(&q, 1.25, &error), LFLARE_OK);
        derive(&q, &small);
        assert_near(small.fnumber, lens.fnumber / 1.25, 1e-9 * lens.fnumber);
        assert_near(iris_of(&small), 1.25 * iris_of(&lens), 1e-9);
        q = p;
        assert_int_equal(lensopt_resize_stop(&q, 0.25, &error), LFLARE_OK);
        derive(&q, &small);
        assert_near(small.fnumber, 4 * lens.fnumber, 1e-9 * lens.fnumber);
        assert_near(iris_of(&small), 0.25 * iris_of(&lens), 1e-9);
        assert_near(small.efl, lens.efl, 1e-12 * lens.efl);
        for (i = 0; i < lens.surface_count; i++)
            if (i != lens.stop) assert_near(small.prescription.surfaces[i].semi_diameter, lens.prescription.surfaces[i].semi_diameter, 0);
        count = GHOSTS;
        assert_int_equal(lflare_ghost_list(&lens, pairs, &count), LFLARE_OK);
        assert_int_equal(lensopt_spots(&lens, pairs, count, 0, iris_of(&lens), was), LFLARE_OK);
        assert_int_equal(lensopt_spots(&small, pairs, count, 0, iris_of(&small), is), LFLARE_OK);
        for (g = 0; g < count; g++) {
            if (was[g].clip != LFLARE_CLIP_IRIS) continue;
            assert_near(is[g].radius, 0.25 * was[g].radius, 1e-9 * was[g].radius);
            assert_near(is[g].irradiance[1], was[g].irradiance[1], 1e-9 * was[g].irradiance[1]);
            seen++;
        }
    }
    print_message("%d ghosts that the iris bounds\n", (int)seen);
    assert_true(seen > 50);
}

/* On the axis the least of all rims as they are seen from the entrance, those in front of the stop times `factor`. */
static double axial_radius(const lflare_lens *lens, lflare_pair pair, double iris, double factor)
{
    lflare_crossing path[LFLARE_MAX_CIRCLES];
    lflare_ghost_matrices m;
    double least = factor * lens->prescription.surfaces[0].semi_diameter;
    int32_t count = LFLARE_MAX_CIRCLES, i;
    assert_int_equal(lflare_ghost_path(lens, 510, pair, path, &count), LFLARE_OK);
    for (i = 0; i < count; i++) {
        double h = path[i].surface == lens->stop ? iris : lens->prescription.surfaces[path[i].surface].semi_diameter;
        least = fmin(least, (path[i].surface < lens->stop ? factor : 1) * h / fabs(path[i].a));
    }
    assert_int_equal(lflare_ghost_optics(lens, 510, &pair, 1, &m), LFLARE_OK);
    return fabs(m.m.a) * least;
}

static void pupils_are_resized(void **state)
{
    static lflare_prescription p, q;
    static lflare_lens lens, other;
    static lflare_pair pairs[GHOSTS];
    static lensopt_spot was[GHOSTS], is[GHOSTS];
    int32_t l, g, i, count, seen = 0, partly = 0;
    lflare_error error;
    (void)state;
    for (l = 0; l < LENSES; l++) {
        read_lens(paths[l], &p, &lens);
        q = p;
        assert_int_equal(lensopt_resize_pupil(&q, 0.5, &error), LFLARE_OK);
        derive(&q, &other);
        assert_near(other.fnumber, lens.fnumber, 1e-12 * lens.fnumber);
        for (i = 0; i < lens.surface_count; i++)
            assert_near(other.prescription.surfaces[i].semi_diameter, (i < lens.stop ? 0.5 : 1) * lens.prescription.surfaces[i].semi_diameter, 1e-12);
        count = GHOSTS;
        assert_int_equal(lflare_ghost_list(&lens, pairs, &count), LFLARE_OK);
        assert_int_equal(lensopt_spots(&lens, pairs, count, 0, iris_of(&lens), was), LFLARE_OK);
        assert_int_equal(lensopt_spots(&other, pairs, count, 0, iris_of(&lens), is), LFLARE_OK);
        for (g = 0; g < count; g++) {
            assert_near(was[g].radius, axial_radius(&lens, pairs[g], iris_of(&lens), 1), 1e-6 * was[g].radius);
            assert_near(is[g].radius, axial_radius(&lens, pairs[g], iris_of(&lens), 0.5), 1e-6 * was[g].radius);
            seen += fabs(is[g].radius - 0.5 * was[g].radius) < 1e-9;
            partly += is[g].radius > 0.5001 * was[g].radius;
        }
    }
    print_message("%d ghosts that the front bounds, %d that it did not before\n", (int)seen, (int)partly);
    assert_true(seen > 20 && partly > 20);
    /* the Heliar's first surface is of 30.81 mm */
    read_lens(paths[0], &p, &lens);
    q = p;
    assert_true(refused(lensopt_resize_pupil(&p, 3, &error), LFLARE_ERROR_LENS, &error, "ends before"));
    assert_memory_equal(&p, &q, sizeof p);
}

/* ---- the stop's place ---- */

static int32_t ghosts_of(const lflare_prescription *p)
{
    int32_t i, k, side[2] = {0, 0}, behind = 0;
    for (i = 0; i < p->surface_count; i++) {
        int steps = 0;
        for (k = 0; k < 4; k++) {
            double nm = k < 3 ? channels[k] : nm_d;
            steps |= fabs(index_behind(p, i - 1, nm) - index_behind(p, i, nm)) > 1e-6;
        }
        if (p->surfaces[i].is_stop) behind = 1;
        else side[behind] += steps;
    }
    return side[0] * (side[0] - 1) / 2 + side[1] * (side[1] - 1) / 2;
}

/* What a moved stop must keep. */
static void check_moved(const lflare_lens *was, const lflare_lens *is)
{
    const lflare_prescription *p = &is->prescription;
    double heights[LFLARE_MAX_SURFACES], entrance = was->efl / (2 * was->fnumber), end, before, length = 0;
    int32_t i;
    for (i = 0; i < is->surface_count; i++) length += p->surfaces[i].thickness - was->prescription.surfaces[i].thickness;
    assert_near(length, 0, 1e-9);
    assert_near(is->efl, was->efl, 1e-9 * was->efl);
    assert_near(is->fnumber, was->fnumber, 1e-9 * was->fnumber);
    if (is->stop < is->surface_count - 1) assert_near(is->bfd, was->bfd, 1e-9 * was->efl);
    end = trace(p, entrance, 0, heights);
    assert_near(p->surfaces[is->stop].semi_diameter, fabs(heights[is->stop]), 1e-9);
    before = trace(&was->prescription, entrance, 0, heights);
    assert_near(end, before, 1e-9);
    assert_int_equal(is->ghost_count, ghosts_of(p));
    assert_true(p->surfaces[is->stop].radius == 0);
}

static void stops_are_moved(void **state)
{
    static lflare_prescription p, q, back;
    static lflare_lens lens, moved;
    int32_t l, i, f, done = 0, glass = 0;
    lflare_error error;
    (void)state;
    for (l = 0; l < LENSES; l++) {
        double gap, part;
        read_lens(paths[l], &p, &lens);
        p.fnumber = (l % 2 == 0 ? 0.8 : 1.3) * lens.fnumber; /* the stop, or what is stated, is the smaller opening */
        p.surfaces[lens.stop].semi_diameter = lens.prescription.surfaces[lens.stop].semi_diameter;
        derive(&p, &lens);
        gap = lens.prescription.surfaces[lens.stop - 1].thickness + lens.prescription.surfaces[lens.stop].thickness;
        part = lens.prescription.surfaces[lens.stop - 1].thickness / gap;
        for (i = 0; i < lens.surface_count; i++)
            for (f = 0; f < 3; f++) {
                double fraction = f == 0 ? 0 : f == 1 ? 0.37 : 1;
                q = p;
                if (i == lens.stop) {
                    assert_true(refused(lensopt_move_stop(&q, i, fraction, &error), LFLARE_ERROR_ARGUMENT, &error, "is the stop itself"));
                } else if (index_behind(&lens.prescription, i, nm_d) != 1) {
                    assert_true(refused(lensopt_move_stop(&q, i, fraction, &error), LFLARE_ERROR_LENS, &error, "is glass"));
                    assert_memory_equal(&p, &q, sizeof p);
                    glass++;
                } else if (i == lens.surface_count - 1 && f == 2) { /* onto the sensor, in focus or so */
                    lensopt_move_stop(&q, i, fraction, &error);
                } else {
                    if (lensopt_move_stop(&q, i, fraction, &error) != LFLARE_OK) fail_msg("%s row %d: %s", paths[l], (int)i, error.text);
                    derive(&q, &moved);
                    assert_int_equal(moved.stop, i + (i < lens.stop));
                    check_moved(&lens, &moved);
                    if (i != lens.stop - 1) assert_near(moved.prescription.surfaces[moved.stop - 1].thickness, fraction * lens.prescription.surfaces[i].thickness, 1e-9);
                    else assert_near(moved.prescription.surfaces[moved.stop - 1].thickness, fraction * gap, 1e-9);
                    /* and to where it was */
                    back = q;
                    if (lens.stop - 1 + (i < lens.stop - 1) == moved.stop) continue;
                    assert_int_equal(lensopt_move_stop(&back, lens.stop - 1 + (i < lens.stop - 1), part, &error), LFLARE_OK);
                    derive(&back, &moved);
                    assert_int_equal(moved.stop, lens.stop);
                    assert_near(moved.prescription.surfaces[lens.stop].thickness, lens.prescription.surfaces[lens.stop].thickness, 1e-9);
                    assert_near(moved.prescription.surfaces[lens.stop].semi_diameter, iris_of(&lens), 1e-9);
                    done++;
                }
            }
    }
    print_message("%d places in air, %d in glass\n", (int)done, (int)glass);
    assert_true(done > 60 && glass > 60);
}

/* ---- one ghost's size ---- */

static double size_of(const lflare_lens *lens, lflare_pair pair, double u, double iris)
{
    lensopt_spot spot;
    assert_int_equal(lensopt_spots(lens, &pair, 1, u, iris, &spot), LFLARE_OK);
    return spot.radius;
}

static int32_t edges_crossing(const lflare_lens *lens)
{
    int32_t i, n = 0;
    for (i = 0; i < lens->note_count; i++) n += lens->notes[i].kind == LFLARE_NOTE_EDGES_CROSS;
    return n;
}

static void ghosts_are_resized(void **state)
{
    static const double factors[3] = {0.7, 0.97, 3}, u = 0.1;
    static lflare_prescription p, q;
    static lflare_lens lens, bent;
    static lflare_pair pairs[GHOSTS];
    int32_t l, g, m, f, i, count, done = 0, tried = 0;
    double apart = 0;
    lflare_error error;
    (void)state;
    for (l = 0; l < LENSES; l++) {
        double iris;
        read_lens(paths[l], &p, &lens);
        iris = 0.5 * iris_of(&lens);
        count = GHOSTS;
        assert_int_equal(lflare_ghost_list(&lens, pairs, &count), LFLARE_OK);
        for (g = 0; g < count; g += 1 + count / 6)
            for (m = 0; m < 3; m++)
                for (f = 0; f < 3; f++) {
                    double was = size_of(&lens, pairs[g], u, iris);
                    lflare_result result;
                    q = p;
                    result = lensopt_resize_ghost(&q, pairs[g], factors[f], (lensopt_mirrors)m, u, iris, &error);
                    tried++;
                    if (result != LFLARE_OK) {
                        assert_true(refused(result, LFLARE_ERROR_LENS, &error, was > 0 ? "times as large" : "is hidden"));
                        assert_memory_equal(&p, &q, sizeof p);
                        continue;
                    }
                    derive(&q, &bent);
                    assert_near(iris_of(&bent), iris_of(&lens), 1e-9);
                    assert_true(bent.efl >= 0.5 * lens.efl && bent.efl <= 2 * lens.efl && edges_crossing(&bent) <= edges_crossing(&lens));
                    apart = fmax(apart, fabs(size_of(&bent, pairs[g], u, iris) / (factors[f] * was) - 1));
                    for (i = 0; i < lens.surface_count; i++) {
                        int may = (i == pairs[g].first && m != LENSOPT_MIRRORS_SECOND) || (i == pairs[g].second && m != LENSOPT_MIRRORS_FIRST);
                        assert_true(may || bent.prescription.surfaces[i].radius == lens.prescription.surfaces[i].radius);
                        assert_true(bent.prescription.surfaces[i].semi_diameter == lens.prescription.surfaces[i].semi_diameter);
                    }
                    done++;
                }
    }
    print_message("%d of %d had, within %.2g\n", (int)done, (int)tried, apart);
    assert_true(done > tried / 2);
    assert_true(apart < 1e-5);
}

/* Between what was and the solution, and as far the other way, nothing that can be made has that size. */
static void check_nearest(const lflare_prescription *p, const lflare_prescription *q, const lflare_lens *lens, lflare_pair pair, int32_t mirror, double goal)
{
    static lflare_prescription r;
    static lflare_lens bent;
    double c0 = p->surfaces[mirror].radius != 0 ? 1 / p->surfaces[mirror].radius : 0, c1 = q->surfaces[mirror].radius != 0 ? 1 / q->surfaces[mirror].radius : 0;
    int32_t k;
    for (k = -98; k < 99; k++) {
        double c = c0 + (c1 - c0) * k / 100;
        r = lens->prescription;
        r.surfaces[mirror].radius = c != 0 ? 1 / c : 0;
        if (lflare_lens_derive(&r, &bent, NULL) != LFLARE_OK || bent.note_count > lens->note_count || bent.efl > 2 * lens->efl || bent.efl < 0.5 * lens->efl) continue;
        assert_true(size_of(&bent, pair, 0, 5) > goal);
    }
    assert_true(c0 != c1);
}

static void the_nearest_curvature_is_taken(void **state)
{
    static lflare_prescription p, q;
    static lflare_lens lens;
    static lflare_pair pairs[GHOSTS];
    int32_t g, m, count = GHOSTS, done = 0;
    lflare_error error;
    (void)state;
    read_lens(paths[0], &p, &lens);
    lflare_ghost_list(&lens, pairs, &count);
    for (g = 0; g < count; g++)
        for (m = LENSOPT_MIRRORS_FIRST; m <= LENSOPT_MIRRORS_SECOND; m++) {
            q = p;
            if (lensopt_resize_ghost(&q, pairs[g], 0.6, (lensopt_mirrors)m, 0, 5, &error) != LFLARE_OK) continue;
            check_nearest(&p, &q, &lens, pairs[g], m == LENSOPT_MIRRORS_FIRST ? pairs[g].first : pairs[g].second, 0.6 * size_of(&lens, pairs[g], 0, 5));
            done++;
        }
    assert_true(done > 8);
}

/* Curvature that an edit gave to both mirrors together. */
static double bending(const lflare_prescription *p, const lflare_prescription *q, lflare_pair pair)
{
    double a = 1 / q->surfaces[pair.first].radius - (p->surfaces[pair.first].radius != 0 ? 1 / p->surfaces[pair.first].radius : 0);
    double b = 1 / q->surfaces[pair.second].radius - (p->surfaces[pair.second].radius != 0 ? 1 / p->surfaces[pair.second].radius : 0);
    return hypot(a, b);
}

static void both_mirrors_share_the_change(void **state)
{
    static lflare_prescription p, q[3];
    static lflare_lens lens;
    static lflare_pair pairs[GHOSTS];
    int32_t l, g, m, count, done = 0;
    (void)state;
    for (l = 0; l < 2; l++) {
        read_lens(paths[l], &p, &lens);
        count = GHOSTS;
        lflare_ghost_list(&lens, pairs, &count);
        for (g = 0; g < count; g++) {
            int all = 1;
            for (m = 0; m < 3; m++) {
                q[m] = p;
                all &= lensopt_resize_ghost(&q[m], pairs[g], 1.005, (lensopt_mirrors)m, 0, 5, NULL) == LFLARE_OK;
                all &= q[m].surfaces[pairs[g].first].radius != 0 && q[m].surfaces[pairs[g].second].radius != 0;
            }
            if (!all) continue;
            assert_true(bending(&p, &q[0], pairs[g]) < 1.01 * bending(&p, &q[1], pairs[g]) && bending(&p, &q[0], pairs[g]) < 1.01 * bending(&p, &q[2], pairs[g]));
            done++;
        }
    }
    assert_true(done > 30);
}

/* What a refusal says of the sizes that can be had holds. */
static void check_refusal(const lflare_prescription *p, lflare_pair pair, lensopt_mirrors mirrors)
{
    static lflare_prescription q;
    lflare_error error;
    double lo, hi;
    q = *p;
    assert_true(refused(lensopt_resize_ghost(&q, pair, 1000, mirrors, 0, 4, &error), LFLARE_ERROR_LENS, &error, "times as large"));
    assert_int_equal(sscanf(error.text, "the ghost of rows %*d and %*d can be about %lf to %lf times", &lo, &hi), 2);
    assert_true(lo <= 1 && hi >= 1);
    if (0.999 * hi > 1) assert_int_equal(lensopt_resize_ghost(&q, pair, 0.999 * hi, mirrors, 0, 4, &error), LFLARE_OK);
    q = *p;
    assert_int_equal(lensopt_resize_ghost(&q, pair, 1.001 * hi, mirrors, 0, 4, &error), LFLARE_ERROR_LENS);
    if (lo > 0.0011) assert_int_equal(lensopt_resize_ghost(&q, pair, 0.999 * lo, mirrors, 0, 4, &error), LFLARE_ERROR_LENS);
    else assert_int_equal(lensopt_resize_ghost(&q, pair, 0.01, mirrors, 0, 4, &error), LFLARE_OK);
}

static void refusals_are_right(void **state)
{
    static lflare_prescription p;
    static lflare_lens lens;
    static lflare_pair pairs[GHOSTS];
    int32_t l, g, count, done = 0;
    (void)state;
    for (l = 0; l < LENSES; l += 4) {
        read_lens(paths[l], &p, &lens);
        count = GHOSTS;
        lflare_ghost_list(&lens, pairs, &count);
        for (g = 0; g < count; g++) {
            if (!(size_of(&lens, pairs[g], 0, 4) > 0)) continue;
            check_refusal(&p, pairs[g], LENSOPT_MIRRORS_FIRST);
            check_refusal(&p, pairs[g], LENSOPT_MIRRORS_SECOND);
            done++;
        }
    }
    assert_true(done > 15);
}

static void side_effects_are_told(void **state)
{
    static lflare_prescription p, q;
    static lflare_lens lens, other;
    static lflare_pair pairs[GHOSTS];
    static lensopt_change changes[2 * GHOSTS];
    lflare_error error;
    int32_t i, of = 0, count, both = 0, gone = 0, come = 0, listed = GHOSTS;
    (void)state;
    read_lens(paths[2], &p, &lens);
    lflare_ghost_list(&lens, pairs, &listed);
    q = p;
    while (lensopt_resize_ghost(&q, pairs[of], 1.2, LENSOPT_MIRRORS_BOTH, 0.05, 3, &error) != LFLARE_OK) assert_true(++of < 10);
    derive(&q, &other);
    count = 2 * GHOSTS;
    assert_int_equal(lensopt_changes(&lens, 3, &other, 3, 0.05, changes, &count), LFLARE_OK);
    assert_int_equal(count, listed);
    for (i = 0; i < count; i++) {
        assert_int_equal(changes[i].there, 3);
        assert_memory_equal(&changes[i].pair_before, &pairs[i], sizeof pairs[i]);
        assert_memory_equal(&changes[i].pair_after, &pairs[i], sizeof pairs[i]);
        assert_true(changes[i].before.radius == size_of(&lens, pairs[i], 0.05, 3) && changes[i].after.radius == size_of(&other, pairs[i], 0.05, 3));
    }
    assert_near(changes[of].after.radius, 1.2 * changes[of].before.radius, 1e-5 * changes[of].before.radius);
    /* a stop that moves past six rows */
    q = p;
    assert_int_equal(lensopt_move_stop(&q, 1, 0.5, &error), LFLARE_OK);
    derive(&q, &other);
    count = 2 * GHOSTS;
    assert_int_equal(lensopt_changes(&lens, iris_of(&lens), &other, iris_of(&other), 0, changes, &count), LFLARE_OK);
    for (i = 0; i < count; i++) {
        const lensopt_change *c = &changes[i];
        both += c->there == 3;
        gone += c->there == 1;
        come += c->there == 2;
        if (c->there == 2) assert_true(c->before.radius == 0);
        if (c->there != 3) continue;
        assert_int_equal(c->pair_before.first - (c->pair_before.first > lens.stop), c->pair_after.first - (c->pair_after.first > other.stop));
        assert_int_equal(c->pair_before.second - (c->pair_before.second > lens.stop), c->pair_after.second - (c->pair_after.second > other.stop));
    }
    assert_int_equal(both + gone, lens.ghost_count);
    assert_int_equal(both + come, other.ghost_count);
    assert_true(both > 0 && gone > 0 && come > 0);
    count = 5;
    assert_int_equal(lensopt_changes(&lens, 3, &other, 3, 0, changes, &count), LFLARE_INCOMPLETE);
    assert_int_equal(count, lens.ghost_count + other.ghost_count);
}

/* ---- coatings ---- */

static void films(const lflare_lens *lens, int32_t surface, lflare_layer *out, int32_t *count)
{
    *count = 8;
    assert_int_equal(lflare_film_layers(lens, surface, out, count), LFLARE_OK);
}

static void coatings_are_set(void **state)
{
    static lflare_prescription p, q;
    static lflare_lens lens;
    lflare_layer layer[8];
    lflare_error error;
    int32_t i, count;
    double n;
    (void)state;
    read_lens(paths[0], &p, &lens);
    assert_int_equal(lensopt_coat_quarter(&p, 0, 440, &error), LFLARE_OK);
    derive(&p, &lens);
    films(&lens, 0, layer, &count);
    n = fmax(sqrt(index_behind(&p, 0, 440)), 1.38);
    assert_int_equal(count, 1);
    assert_near(layer[0].n, n, 1e-12);
    assert_near(layer[0].thickness_nm, 110 / n, 1e-9);
    for (i = 0; i < 5; i++) assert_int_equal(lensopt_coat_layer(&p, i, 1.4 + 0.1 * i, 100 + 10 * i, &error), LFLARE_OK);
    assert_int_equal(p.layer_count, 5);
    /* one is replaced, one goes, one becomes a quarter-wave; the others keep theirs */
    assert_int_equal(lensopt_coat_layer(&p, 1, 1.9, 750, &error), LFLARE_OK);
    assert_int_equal(lensopt_coat_bare(&p, 2, &error), LFLARE_OK);
    assert_int_equal(lensopt_coat_quarter(&p, 0, 600, &error), LFLARE_OK);
    assert_int_equal(p.layer_count, 3);
    derive(&p, &lens);
    for (i = 0; i < 5; i++) {
        static const double ns[5] = {0, 1.9, 0, 1.7, 1.8}, thick[5] = {0, 750, 0, 130, 140};
        films(&lens, i, layer, &count);
        assert_int_equal(count, i != 2);
        if (ns[i] > 0) assert_true(fabs(layer[0].n - ns[i]) < 1e-12 && fabs(layer[0].thickness_nm - thick[i]) < 1e-12);
    }
    /* layers that two surfaces share stay when one leaves them */
    p.surfaces[7].coating = LFLARE_COATING_STACK;
    p.surfaces[7].first_layer = p.surfaces[3].first_layer;
    p.surfaces[7].layer_count = 1;
    assert_int_equal(lensopt_coat_bare(&p, 3, &error), LFLARE_OK);
    assert_int_equal(p.layer_count, 3);
    derive(&p, &lens);
    films(&lens, 7, layer, &count);
    assert_true(count == 1 && fabs(layer[0].n - 1.7) < 1e-12);
    assert_int_equal(lensopt_coat_quarter(&p, 7, 500, &error), LFLARE_OK);
    assert_int_equal(p.layer_count, 2);
    /* all layers taken */
    for (p.layer_count = 0; p.layer_count < LFLARE_MAX_LAYERS; p.layer_count++) p.layers[p.layer_count].n = 1.5, p.layers[p.layer_count].thickness_nm = 50;
    for (i = 0; i < p.surface_count; i++) p.surfaces[i].coating = LFLARE_COATING_NONE;
    p.surfaces[8].coating = LFLARE_COATING_STACK;
    p.surfaces[8].first_layer = 0;
    p.surfaces[8].layer_count = LFLARE_MAX_LAYERS;
    q = p;
    assert_true(refused(lensopt_coat_layer(&p, 0, 1.5, 100, &error), LFLARE_ERROR_LIMIT, &error, "1024 layers"));
    assert_memory_equal(&p, &q, sizeof p);
    assert_int_equal(lensopt_coat_layer(&p, 8, 1.5, 100, &error), LFLARE_OK);
    assert_int_equal(p.layer_count, 1);
}

/* ---- colour ---- */

/* W with these coatings really set, over the whole path. */
static void full_path(const lflare_prescription *p, lflare_pair pair, double u, double iris, double first_nm, double second_nm, double *rgb)
{
    static lflare_prescription q;
    static lflare_lens lens;
    lflare_region region;
    int32_t c;
    q = *p;
    assert_int_equal(lensopt_coat_quarter(&q, pair.first, first_nm, NULL), LFLARE_OK);
    assert_int_equal(lensopt_coat_quarter(&q, pair.second, second_nm, NULL), LFLARE_OK);
    derive(&q, &lens);
    lflare_ghost_clip(&lens, 510, pair, iris, u, &region);
    for (c = 0; c < 3; c++) rgb[c] = lflare_ghost_weight(&lens, channels[c], pair, region.centroid, u);
}

static double hue_distance(const double *a, const double *b)
{
    double s = a[0] + a[1] + a[2], t = b[0] + b[1] + b[2];
    return sqrt(pow(a[0] / s - b[0] / t, 2) + pow(a[1] / s - b[1] / t, 2) + pow(a[2] / s - b[2] / t, 2));
}

static void colour_maps_are_full_paths(void **state)
{
    static float pixels[3 * LENSOPT_COLOUR_STEPS * LENSOPT_COLOUR_STEPS];
    static lflare_prescription p;
    static lflare_lens lens;
    static lflare_pair pairs[GHOSTS];
    static lensopt_colour_map map;
    double apart = 0, now = 0;
    int32_t l, g, k, c, count;
    (void)state;
    for (l = 0; l < LENSES; l++) {
        double iris, u = 0.04 * l;
        read_lens(paths[l], &p, &lens);
        iris = 0.6 * iris_of(&lens);
        count = GHOSTS;
        lflare_ghost_list(&lens, pairs, &count);
        for (g = 0; g < count; g += 1 + count / 7) {
            lensopt_spot spot;
            assert_int_equal(lensopt_colour_map_make(&lens, pairs[g], u, iris, &map), LFLARE_OK);
            lensopt_colour_map_floats(&map, pixels);
            assert_int_equal(lensopt_spots(&lens, &pairs[g], 1, u, iris, &spot), LFLARE_OK);
            assert_int_equal(map.clip, spot.clip);
            for (c = 0; c < 3 && spot.radius > 0; c++) now = fmax(now, fabs(map.now[c] * map.scale / spot.irradiance[c] - 1));
            for (k = 0; k < 12; k++) {
                int32_t i = (37 * k + g) % LENSOPT_COLOUR_STEPS, j = (101 * k + 5 * g + 185) % LENSOPT_COLOUR_STEPS;
                double rgb[3];
                full_path(&p, pairs[g], u, iris, 380 + 2 * i, 380 + 2 * j, rgb);
                for (c = 0; c < 3; c++) apart = fmax(apart, fabs((double)pixels[3 * (LENSOPT_COLOUR_STEPS * j + i) + c] / rgb[c] - 1));
                for (c = 0; c < 3; c++) assert_near(map.path[c] * map.first[i][c] * map.second[j][c] / rgb[c], 1, 1e-11);
            }
        }
    }
    print_message("W within %.2g as floats, of what is there within %.2g\n", apart, now);
    assert_true(apart < 2e-7 && now < 1e-11);
}

static void best_points_are_best(void **state)
{
    static const double targets[4][3] = {{1, 0.2, 0.1}, {0.1, 0.3, 1}, {0.6, 0, 0.5}, {1, 1, 1}};
    static lflare_prescription p;
    static lflare_lens lens;
    static lflare_pair pairs[GHOSTS];
    static lensopt_colour_map map;
    int32_t l, t, i, j, count;
    (void)state;
    for (l = 0; l < 2; l++) {
        lensopt_colour_point best, bright;
        double rgb[3], twice[3];
        read_lens(paths[l], &p, &lens);
        count = GHOSTS;
        lflare_ghost_list(&lens, pairs, &count);
        assert_int_equal(lensopt_colour_map_make(&lens, pairs[2], 0.05, 4, &map), LFLARE_OK);
        for (t = 0; t < 4; t++) {
            assert_int_equal(lensopt_colour_best(&map, targets[t], 0, &best), LFLARE_OK);
            full_path(&p, pairs[2], 0.05, 4, best.first_nm, best.second_nm, rgb);
            assert_near(best.distance, hue_distance(rgb, targets[t]), 1e-10);
            for (i = 0; i < 186; i += 23)
                for (j = 0; j < 186; j += 23) {
                    full_path(&p, pairs[2], 0.05, 4, 380 + 2 * i, 380 + 2 * j, rgb);
                    assert_true(best.distance <= hue_distance(rgb, targets[t]) + 1e-10);
                }
            for (i = -2; i <= 2; i += 2) /* and its neighbours */
                for (j = -2; j <= 2; j += 2) {
                    double x = best.first_nm + i, y = best.second_nm + j;
                    if (x < 380 || x > 750 || y < 380 || y > 750) continue;
                    full_path(&p, pairs[2], 0.05, 4, x, y, rgb);
                    assert_true(best.distance <= hue_distance(rgb, targets[t]) + 1e-10);
                }
        }
        /* a colour that is there is found; with brightness exactly its place, if it is asked for twice as bright another one */
        full_path(&p, pairs[2], 0.05, 4, 506, 442, rgb);
        assert_int_equal(lensopt_colour_best(&map, rgb, 0, &best), LFLARE_OK);
        assert_true(best.distance < 1e-10);
        assert_int_equal(lensopt_colour_best(&map, rgb, 1, &best), LFLARE_OK);
        assert_true(best.distance < 1e-10 && fabs(best.rgb[0] / rgb[0] - 1) < 1e-9);
        for (i = 0; i < 3; i++) twice[i] = 2 * rgb[i];
        assert_int_equal(lensopt_colour_best(&map, twice, 1, &bright), LFLARE_OK);
        assert_true(bright.distance > 1e-4 && bright.distance < log(2.0));
        assert_true(bright.rgb[0] + bright.rgb[1] + bright.rgb[2] > best.rgb[0] + best.rgb[1] + best.rgb[2]);
        assert_near(bright.distance, hue_distance(bright.rgb, twice) + fabs(log((bright.rgb[0] + bright.rgb[1] + bright.rgb[2]) / (twice[0] + twice[1] + twice[2]))), 1e-12);
    }
}

/* Airy's sum of one layer at normal incidence. */
static double airy(double n0, double n1, double n2, double thickness, double nm)
{
    double a = (n0 - n1) / (n0 + n1), b = (n1 - n2) / (n1 + n2), c = cos(4 * 3.14159265358979323846 * n1 * thickness / nm);
    return (a * a + b * b + 2 * a * b * c) / (1 + a * a * b * b + 2 * a * b * c);
}

static void reflectances_are_airys(void **state)
{
    static lflare_prescription p;
    static lflare_lens lens;
    double nm[41], r[41], rgb[3 * 41];
    int32_t i, c, row, rows = 0;
    (void)state;
    read_lens(paths[0], &p, &lens);
    assert_int_equal(lensopt_coat_layer(&p, 4, 1.62, 333, NULL), LFLARE_OK);
    derive(&p, &lens);
    for (i = 0; i < 41; i++) nm[i] = 380 + 10 * i;
    assert_int_equal(lensopt_reflectance(&lens, 4, 0, nm, 41, r), LFLARE_OK);
    for (i = 0; i < 41; i++) assert_near(r[i], airy(index_behind(&p, 3, nm[i]), 1.62, 1, 333, nm[i]), 1e-12);
    for (row = 0; row < lens.surface_count; row++) {
        if (row == lens.stop) continue;
        assert_int_equal(lensopt_quarter_reflectance(&lens, row, 0, nm, 41, rgb), LFLARE_OK);
        for (i = 0; i < 41; i++)
            for (c = 0; c < 3; c++) {
                double n = fmax(sqrt(index_behind(&p, row - 1, nm[i]) * index_behind(&p, row, nm[i])), 1.38);
                assert_near(rgb[3 * i + c], airy(index_behind(&p, row - 1, channels[c]), n, index_behind(&p, row, channels[c]), nm[i] / (4 * n), channels[c]), 1e-12);
            }
        rows++;
    }
    assert_int_equal(rows, 8);
    /* inclined, from glass into air beyond the angle of total reflection */
    assert_int_equal(lensopt_reflectance(&lens, 4, 1.1, nm, 1, r), LFLARE_OK);
    assert_near(r[0], 1, 0);
    assert_int_equal(lensopt_coat_bare(&p, 0, NULL), LFLARE_OK);
    derive(&p, &lens);
    assert_int_equal(lensopt_reflectance(&lens, 0, 0, nm, 1, r), LFLARE_OK);
    assert_near(r[0], pow((index_behind(&p, 0, 380) - 1) / (index_behind(&p, 0, 380) + 1), 2), 1e-12);
}

/* ---- what cannot be ---- */

static void edits_are_checked(void **state)
{
    static lflare_prescription p, q;
    static lflare_lens lens;
    lflare_pair pair = {3, 2, 0, 0}, across = {7, 2, 0, 0}, four = {3, 2, 4, 1};
    lflare_error e;
    (void)state;
    read_lens(paths[0], &p, &lens);
    q = p;
    assert_true(refused(lensopt_resize_stop(NULL, 1, &e), LFLARE_ERROR_ARGUMENT, &e, "prescription"));
    assert_true(refused(lensopt_resize_stop(&p, 0, &e), LFLARE_ERROR_ARGUMENT, &e, "0.001 to 1000 was expected, not 0"));
    assert_true(refused(lensopt_resize_stop(&p, (double)NAN, &e), LFLARE_ERROR_ARGUMENT, &e, "no number"));
    assert_true(refused(lensopt_resize_stop(&p, 500, &e), LFLARE_ERROR_LENS, &e, "f-number"));
    assert_true(refused(lensopt_resize_pupil(NULL, 1, &e), LFLARE_ERROR_ARGUMENT, &e, "prescription"));
    assert_true(refused(lensopt_resize_pupil(&p, -1, &e), LFLARE_ERROR_ARGUMENT, &e, "not -1"));
    assert_true(refused(lensopt_move_stop(NULL, 1, 0.5, &e), LFLARE_ERROR_ARGUMENT, &e, "prescription"));
    assert_true(refused(lensopt_move_stop(&p, -1, 0.5, &e), LFLARE_ERROR_ARGUMENT, &e, "a row from 1 to 9 was expected, not 0"));
    assert_true(refused(lensopt_move_stop(&p, 9, 0.5, &e), LFLARE_ERROR_ARGUMENT, &e, "not 10"));
    assert_true(refused(lensopt_move_stop(&p, 2, 1.5, &e), LFLARE_ERROR_ARGUMENT, &e, "fraction"));
    assert_true(refused(lensopt_move_stop(&p, 2, (double)NAN, &e), LFLARE_ERROR_ARGUMENT, &e, "fraction"));
    assert_true(refused(lensopt_resize_ghost(NULL, pair, 1, LENSOPT_MIRRORS_BOTH, 0, 5, &e), LFLARE_ERROR_ARGUMENT, &e, "prescription"));
    assert_true(refused(lensopt_resize_ghost(&p, pair, (double)NAN, LENSOPT_MIRRORS_BOTH, 0, 5, &e), LFLARE_ERROR_ARGUMENT, &e, "no number"));
    assert_true(refused(lensopt_resize_ghost(&p, pair, 1.1, LENSOPT_MIRRORS_BOTH, -1, 5, &e), LFLARE_ERROR_ARGUMENT, &e, "slope"));
    assert_true(refused(lensopt_resize_ghost(&p, pair, 1.1, LENSOPT_MIRRORS_BOTH, 0, 0, &e), LFLARE_ERROR_ARGUMENT, &e, "iris"));
    assert_true(refused(lensopt_resize_ghost(&p, pair, 1.1, (lensopt_mirrors)3, 0, 5, &e), LFLARE_ERROR_ARGUMENT, &e, "mirror"));
    assert_true(refused(lensopt_resize_ghost(&p, across, 1.1, LENSOPT_MIRRORS_BOTH, 0, 5, &e), LFLARE_ERROR_ARGUMENT, &e, "rows 8 and 3 make no ghost"));
    assert_true(refused(lensopt_resize_ghost(&p, four, 1.1, LENSOPT_MIRRORS_BOTH, 0, 5, &e), LFLARE_ERROR_ARGUMENT, &e, "two reflections"));
    assert_true(refused(lensopt_resize_ghost(&p, pair, 1.1, LENSOPT_MIRRORS_BOTH, 50, 5, &e), LFLARE_ERROR_LENS, &e, "hidden"));
    assert_true(refused(lensopt_coat_quarter(NULL, 0, 500, &e), LFLARE_ERROR_ARGUMENT, &e, "prescription"));
    assert_true(refused(lensopt_coat_quarter(&p, 0, 99, &e), LFLARE_ERROR_ARGUMENT, &e, "100 to 20000"));
    assert_true(refused(lensopt_coat_quarter(&p, 0, (double)NAN, &e), LFLARE_ERROR_ARGUMENT, &e, "100 to 20000"));
    assert_true(refused(lensopt_coat_quarter(&p, 5, 500, &e), LFLARE_ERROR_ARGUMENT, &e, "row 6 is the stop"));
    assert_true(refused(lensopt_coat_quarter(&p, 9, 500, &e), LFLARE_ERROR_ARGUMENT, &e, "from 1 to 9"));
    assert_true(refused(lensopt_coat_bare(&p, -1, &e), LFLARE_ERROR_ARGUMENT, &e, "not 0"));
    assert_true(refused(lensopt_coat_layer(&p, 0, 0.9, 100, &e), LFLARE_ERROR_ARGUMENT, &e, "index"));
    assert_true(refused(lensopt_coat_layer(&p, 0, 1.5, 0, &e), LFLARE_ERROR_ARGUMENT, &e, "thickness"));
    assert_int_equal(lensopt_coat_layer(&p, 0, (double)NAN, 100, NULL), LFLARE_ERROR_ARGUMENT);
    assert_memory_equal(&p, &q, sizeof p);
    assert_int_equal(lensopt_resize_ghost(&p, pair, 1, LENSOPT_MIRRORS_BOTH, 0, 5, &e), LFLARE_OK); /* nothing to do */
    assert_true(p.surfaces[3].radius == q.surfaces[3].radius);
    p.surface_count = 1000;
    assert_int_equal(lensopt_coat_bare(&p, 0, &e), LFLARE_ERROR_LENS);
    p = q;
    p.layer_count = -5;
    assert_true(refused(lensopt_coat_layer(&p, 0, 1.5, 100, &e), LFLARE_ERROR_ARGUMENT, &e, "layers"));
}

static void colours_are_checked(void **state)
{
    static lflare_prescription p;
    static lflare_lens lens;
    static lensopt_colour_map map;
    static lensopt_change change;
    lensopt_colour_point best;
    lflare_pair pair = {3, 2, 0, 0}, across = {7, 2, 0, 0};
    double rgb[3] = {1, 0, 0}, none[3] = {0, 0, 0}, nm = 500, out[3];
    int32_t count = 0;
    (void)state;
    read_lens(paths[0], &p, &lens);
    assert_int_equal(lensopt_colour_map_make(NULL, pair, 0, 5, &map), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_colour_map_make(&lens, pair, 0, 5, NULL), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_colour_map_make(&lens, across, 0, 5, &map), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_colour_map_make(&lens, pair, (double)NAN, 5, &map), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_colour_map_make(&lens, pair, 0, 0, &map), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_colour_map_make(&lens, pair, 0, 5, &map), LFLARE_OK);
    assert_int_equal(lensopt_colour_best(NULL, rgb, 0, &best), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_colour_best(&map, NULL, 0, &best), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_colour_best(&map, rgb, 0, NULL), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_colour_best(&map, none, 0, &best), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_colour_best(&map, rgb, -1, &best), LFLARE_ERROR_ARGUMENT);
    rgb[1] = (double)NAN;
    assert_int_equal(lensopt_colour_best(&map, rgb, 0, &best), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_reflectance(NULL, 0, 0, &nm, 1, out), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_reflectance(&lens, 5, 0, &nm, 1, out), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_reflectance(&lens, 0, -1, &nm, 1, out), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_reflectance(&lens, 0, 0, NULL, 1, out), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_reflectance(&lens, 0, 0, NULL, 0, NULL), LFLARE_OK);
    nm = (double)NAN;
    assert_int_equal(lensopt_quarter_reflectance(&lens, 0, 0, &nm, 1, out), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_changes(NULL, 1, &lens, 1, 0, NULL, &count), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_changes(&lens, 0, &lens, 1, 0, NULL, &count), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_changes(&lens, 1, &lens, 1, (double)NAN, NULL, &count), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_changes(&lens, 1, &lens, 1, 0, NULL, &count), LFLARE_INCOMPLETE);
    count = 1;
    assert_int_equal(lensopt_changes(&lens, 1, &lens, 1, 0, &change, &count), LFLARE_INCOMPLETE);
    assert_int_equal(count, 2 * lens.ghost_count);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(stops_are_resized),          cmocka_unit_test(pupils_are_resized),     cmocka_unit_test(stops_are_moved),
        cmocka_unit_test(ghosts_are_resized),         cmocka_unit_test(the_nearest_curvature_is_taken), cmocka_unit_test(refusals_are_right), cmocka_unit_test(both_mirrors_share_the_change),
        cmocka_unit_test(side_effects_are_told),      cmocka_unit_test(coatings_are_set),       cmocka_unit_test(colour_maps_are_full_paths),
        cmocka_unit_test(best_points_are_best),       cmocka_unit_test(reflectances_are_airys), cmocka_unit_test(edits_are_checked),
        cmocka_unit_test(colours_are_checked)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
