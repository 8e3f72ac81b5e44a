/* Targets of lensopt.h: what a lens shows, as text and back; and every way in which text is none. */
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

enum { ROOM = 1 << 18 };
static lensopt_target target, again;
static char text[ROOM];

static void derive(const char *path, lflare_lens *lens)
{
    static lflare_prescription p;
    lflare_error error;
    char *file;
    size_t size;
    assert_int_equal(lflare_file_read(path, NULL, NULL, &file, &size, &error), LFLARE_OK);
    assert_int_equal(lflare_text_read(file, size, &p, &error), LFLARE_OK);
    assert_int_equal(lflare_lens_derive(&p, lens, &error), LFLARE_OK);
    free(file);
}

static void same_again(void)
{
    lflare_error error;
    size_t size = ROOM;
    assert_int_equal(lensopt_target_write(&target, text, &size), LFLARE_OK);
    assert_int_equal(lensopt_target_read(text, size, &again, &error), LFLARE_OK);
    assert_memory_equal(&target, &again, sizeof target);
}

/* Spots of three lights, picked, changed, written and read. */
static void picked_from_lenses(void **state)
{
    static const char *const paths[3] = {"lenses/heliar-tronnier.lens", "lenses/canon-28-80.lens", "lenses/nikon-80-200-mid.lens"};
    static const lensopt_light lights[3] = {{{5.45, 0}, 1}, {{-13.4, 7}, 2}, {{0, 0}, 0.5}};
    static lflare_lens lens;
    lflare_iris iris;
    lflare_error error;
    int32_t l, i, k;
    (void)state;
    for (l = 0; l < 3; l++) {
        derive(paths[l], &lens);
        assert_int_equal(lflare_iris_make(&lens, 8, 0, 0, 0, &iris, NULL), LFLARE_OK);
        assert_int_equal(lensopt_target_of(&lens, lights, 3, (double)iris.radius, &target, &error), LFLARE_OK);
        assert_true(target.ghost_count > 5 && target.ghost_count <= lens.ghost_count);
        assert_int_equal(lensopt_target_check(&target, &error), LFLARE_OK);
        for (i = 0; i < target.ghost_count; i++)
            for (k = 0; k < 3; k++) {
                lensopt_spot spot;
                const lensopt_goal *goal = &target.ghosts[i].goals[k];
                assert_int_equal(lensopt_spots(&lens, &target.ghosts[i].pair, 1, lensopt_slope(&lights[k]), (double)iris.radius, &spot), LFLARE_OK);
                assert_true((goal->wish == LENSOPT_SPOT) == (spot.radius > 1e-6));
                if (goal->wish == LENSOPT_SPOT) assert_true(goal->centre == spot.centre && goal->radius == spot.radius);
            }
        same_again();
        target.ghosts[0].pair.first = -1;
        target.ghosts[0].pair.second = 0;
        target.ghosts[1].weight = 1.0 / 3;
        target.ghosts[2].goals[1].wish = LENSOPT_SPOT_ANY;
        target.ghosts[2].goals[1].centre = target.ghosts[2].goals[1].radius = 0;
        memset(target.ghosts[3].color, 0, sizeof target.ghosts[3].color);
        target.stop_locks = LENSOPT_LOCK_STOP_PLACE;
        target.locks[0] = LENSOPT_LOCK_RADIUS | LENSOPT_LOCK_MEDIUM;
        target.locks[127] = LENSOPT_LOCK_GAP | LENSOPT_LOCK_COATING;
        same_again();
    }
}

#define BEGINNING "lensopt 1\nsensor 36 24\nlight 5 0\nlight 0 -3 weight 2\n"

static void read_by_hand(void **state)
{
    static const char by_hand[] = "# a flare\r\nlensopt 1\r\nname  two of them \r\nlight 5.5 -2 # the sun\r\nsensor 36 24\r\nghost 4,2 weight 0 color 1 .5 0\r\n spot -3 1.5\r\n"
                                  "ghost\r\n\tspot hidden\r\nlock 3 radius gap\r\nlock stop place radius";
    lflare_error error;
    (void)state;
    assert_int_equal(lensopt_target_read(by_hand, sizeof by_hand - 1, &target, &error), LFLARE_OK);
    assert_string_equal(target.name, "two of them");
    assert_int_equal(target.light_count, 1);
    assert_int_equal(target.ghost_count, 2);
    assert_true(target.lights[0].direction[0] == 5.5 && target.lights[0].direction[1] == -2 && target.lights[0].weight == 1);
    assert_true(target.ghosts[0].pair.first == 3 && target.ghosts[0].pair.second == 1 && target.ghosts[0].weight == 0 && target.ghosts[0].color[1] == 0.5);
    assert_true(target.ghosts[0].goals[0].centre == -3 && target.ghosts[0].goals[0].radius == 1.5);
    assert_true(target.ghosts[1].pair.first == -1 && target.ghosts[1].goals[0].wish == LENSOPT_SPOT_HIDDEN);
    assert_int_equal(target.locks[2], LENSOPT_LOCK_RADIUS | LENSOPT_LOCK_GAP);
    assert_int_equal(target.stop_locks, LENSOPT_LOCK_STOP_RADIUS | LENSOPT_LOCK_STOP_PLACE);
    same_again();
}

static void faults_have_a_place(void **state)
{
    static const struct {
        const char *text;
        int32_t line, column;
        const char *says;
    } cases[] = {
        {"", 1, 1, "expected lensopt 1"},
        {"# nothing", 1, 1, "expected lensopt 1"},
        {"lensflare 1\n", 1, 1, "found 'lensflare'"},
        {"lensopt 2\n", 1, 9, "expected version 1, found '2'"},
        {"lensopt 1\nsensor 36\n", 2, 10, "a height from 0.001 to 1e5 mm, found the end of the line"},
        {"lensopt 1\nsensor 36 nan\n", 2, 11, "found 'nan'"},
        {"lensopt 1\nsensor 36 24 1\n", 2, 14, "the end of the line"},
        {"lensopt 1\nsensor 36 24\nsensor 36 24\n", 3, 1, "sensor (once)"},
        {"lensopt 1\nlight 90 0\n", 2, 7, "degrees between"},
        {"lensopt 1\nlight 0 0 weight -1\n", 2, 18, "a weight"},
        {"lensopt 1\nlight 0 0 heavy\n", 2, 11, "expected weight"},
        {"lensopt 1\nghost\n", 2, 1, "a light before the ghosts"},
        {"lensopt 1\nname\n", 2, 5, "a name of 1 to 95 bytes"},
        {"lensopt 1\nname a\nname b\n", 3, 6, "one name only"},
        {"lensopt 1\nlicht 0 0\n", 2, 1, "light, ghost, spot or lock, found 'licht'"},
        {"lensopt 1\nlock stop gap\n", 2, 11, "radius or place"},
        {"lensopt 1\nlock 0 gap\n", 2, 6, "a surface from 1 to 128"},
        {"lensopt 1\nlock 129 gap\n", 2, 6, "a surface from 1 to 128"},
        {"lensopt 1\nlock 1.5 gap\n", 2, 6, "a surface from 1 to 128"},
        {"lensopt 1\nlock 1\n", 2, 7, "radius, gap, medium or coating"},
        {"lensopt 1\nspot 1 1\n", 2, 1, "a ghost before its spots"},
        {BEGINNING "ghost 2,4\n", 5, 7, "I behind J"},
        {BEGINNING "ghost 4,\n", 5, 7, "surfaces I,J"},
        {BEGINNING "ghost 4,0\n", 5, 7, "surfaces I,J"},
        {BEGINNING "ghost 4,3,2\n", 5, 7, "surfaces I,J"},
        {BEGINNING "ghost 4,3,3,2\n", 5, 7, "K behind J"},
        {BEGINNING "ghost 4,3,2,1,1\n", 5, 7, "surfaces I,J"},
        {BEGINNING "ghost 200,1\n", 5, 7, "from 1 to 128"},
        {BEGINNING "ghost 99999999999,1\n", 5, 7, "surfaces I,J"},
        {BEGINNING "ghost color 1 2\n", 5, 16, "color R G B"},
        {BEGINNING "ghost colour 1 2 3\n", 5, 7, "color or weight"},
        {BEGINNING "ghost 4,2\nspot 1 1\nghost\n", 7, 1, "a spot for each light"},
        {BEGINNING "ghost 4,2\nspot 1 1\n", 7, 1, "a spot for each light"},
        {BEGINNING "ghost 4,2\nspot 1 1\nspot any\nspot any\n", 8, 1, "no more spots than lights"},
        {BEGINNING "ghost 4,2\nspot 1 0\n", 6, 8, "a radius"},
        {BEGINNING "ghost 4,2\nspot 1\n", 6, 7, "a radius"},
        {BEGINNING "ghost 4,2\nspot\n", 6, 5, "CENTRE RADIUS"},
        {BEGINNING "ghost 4,2\nspot hidden 1\n", 6, 13, "the end of the line"},
        {BEGINNING "ghost 4,2\nspot any\nspot any\nlight 1 1\n", 8, 1, "lights before the ghosts"},
        {"lensopt 1\nlight 0 0\nghost\nspot 1 1\n", 5, 1, "sensor WIDTH HEIGHT"},
        {"lensopt 1\nsensor 36 24\n", 3, 1, "at least one light"},
        {BEGINNING, 5, 1, "at least one ghost"}};
    size_t c;
    (void)state;
    for (c = 0; c < sizeof cases / sizeof *cases; c++) {
        lflare_error error;
        memset(&error, 0, sizeof error);
        assert_int_equal(lensopt_target_read(cases[c].text, strlen(cases[c].text), &target, NULL), LFLARE_ERROR_SYNTAX);
        assert_int_equal(lensopt_target_read(cases[c].text, strlen(cases[c].text), &target, &error), LFLARE_ERROR_SYNTAX);
        if (error.line != cases[c].line || error.column != cases[c].column || strstr(error.text, cases[c].says) == NULL)
            print_error("case %d: %d:%d %s\n", (int)c, (int)error.line, (int)error.column, error.text);
        assert_int_equal(error.line, cases[c].line);
        assert_int_equal(error.column, cases[c].column);
        assert_non_null(strstr(error.text, cases[c].says));
    }
}

static void limits(void **state)
{
    static const lensopt_light axis = {{0, 0}, 1};
    static lflare_lens lens;
    lflare_error error;
    size_t size = 0, i;
    (void)state;
    size = (size_t)sprintf(text, "%s", "lensopt 1\nsensor 36 24\nlight 0 0\n");
    for (i = 0; i < 10000; i++) size += (size_t)sprintf(text + size, "ghost\nspot any\n");
    assert_int_equal(lensopt_target_read(text, size, &target, &error), LFLARE_ERROR_SYNTAX);
    assert_int_equal(error.line, 4 + 2 * LENSOPT_MAX_GHOSTS);
    assert_non_null(strstr(error.text, "at most 1024 ghosts"));
    for (size = 10, i = 0; i < 9; i++) size += (size_t)sprintf(text + size, "light 0 0\n");
    assert_int_equal(lensopt_target_read(text, size, &target, &error), LFLARE_ERROR_SYNTAX);
    assert_non_null(strstr(error.text, "at most 8 lights"));
    size = (size_t)sprintf(text, BEGINNING "ghost\nspot any\nspot any\n");
    assert_int_equal(lensopt_target_read(text, size, &target, &error), LFLARE_OK);
    for (i = 0; i < size; i++) { /* what does not fit is counted */
        size_t room = i;
        assert_int_equal(lensopt_target_write(&target, text, &room), LFLARE_INCOMPLETE);
        assert_true(room > i);
    }
    again = target;
    again.ghosts[0].weight = (double)NAN;
    assert_int_equal(lensopt_target_check(&again, &error), LFLARE_ERROR_ARGUMENT);
    assert_string_equal(error.text, "ghost 1: expected a weight from 0 to 1e9");
    again = target;
    again.lights[1].direction[0] = (double)INFINITY;
    assert_int_equal(lensopt_target_check(&again, &error), LFLARE_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "light 2: "));
    again = target;
    again.ghost_count = 0;
    size = ROOM;
    assert_int_equal(lensopt_target_check(&again, NULL), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_target_write(&again, text, &size), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_target_check(NULL, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_target_read(NULL, 1, &target, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_target_write(&target, NULL, NULL), LFLARE_ERROR_ARGUMENT);
    derive("lenses/heliar-tronnier.lens", &lens);
    assert_int_equal(lensopt_target_of(NULL, &axis, 1, 5, &target, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_target_of(&lens, &axis, 0, 5, &target, &error), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lensopt_target_of(&lens, &axis, 1, (double)NAN, &target, &error), LFLARE_ERROR_ARGUMENT);
}

/* Texts cut off and with bytes changed: an error, or a target that comes back the same. */
static void any_bytes_are_safe(void **state)
{
    static const char seed[] = BEGINNING "name x\nghost 4,2 color 1 2 3 weight 1e-3\n spot -1.5 2\n spot hidden\nghost 9,7,8,1\nspot any\nspot 0 1 # c\nlock 3 gap medium\nlock stop place\n";
    char *bytes = (char *)malloc(sizeof seed);
    uint32_t random = 1;
    int32_t i, accepted = 0;
    (void)state;
    for (i = 0; i < 20000; i++) {
        size_t size = sizeof seed - 1, k;
        if (i < (int32_t)sizeof seed) size = (size_t)i;
        memcpy(bytes, seed, sizeof seed);
        for (k = 0; i >= (int32_t)sizeof seed && k < 1; k++) {
            random = random * 1664525u + 1013904223u;
            bytes[(random >> 8) % size] = random & 1 ? (char)(random >> 24) : seed[(random >> 16) % size];
        }
        if (lensopt_target_read(bytes, size, &target, NULL) != LFLARE_OK) continue;
        same_again();
        accepted++;
    }
    assert_true(accepted > 100 && accepted < 19000);
    free(bytes);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {cmocka_unit_test(picked_from_lenses), cmocka_unit_test(read_by_hand), cmocka_unit_test(faults_have_a_place), cmocka_unit_test(limits), cmocka_unit_test(any_bytes_are_safe)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
