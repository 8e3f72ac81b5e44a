/* Of flare, the command-line tool: lenses changed for their flare with lensopt.h. Included by flare.c alone, behind its lenses and
   pictures, whose functions it uses. */

static const char help_edit[] =
    "  flare edit    LENS -o OUT.lens [--stop-radius FACTOR] [--pupil FACTOR] [--move-stop ROW[,FRACTION]] [--angle AX,AY] [--fnumber N]\n"
    "                [--ghost I,J --size FACTOR [--surface I|J|both]] [--coating ROW=quarter:NM|layer:N,NM|bare]...\n"
    "      a lens changed for its flare; prints what has changed. Surfaces are those of LENS whatever else is asked for\n"
    "      --stop-radius: the iris's full opening; --pupil: clear semi-diameters in front of the stop, both as factors\n"
    "      --move-stop: into the air behind that surface, at a fraction (0.5) of the gap; focal length and f-number stay\n"
    "      --size: the ghost I,J that much larger, by the radius of one or both (default) of its surfaces, with a table of what becomes of the\n"
    "      others for that light and iris\n"
    "      --coating: a quarter-wave layer, one of index N (1.38 to 1.9 can be had) and NM (25 to 750), or none\n"
    "  flare colour-map LENS --ghost I,J -o MAP.png [--angle AX,AY] [--fnumber N] [--target R,G,B] [--across-stop]\n"
    "      hues of a ghost over the quarter-wave coatings of its two surfaces, 380 to 750 nm, the first to the right, the second upwards;\n"
    "      with a target the point whose hue is nearest is marked and printed\n"
    "  flare target  LENS|FILE.target -o OUT.target [--light AX,AY]... [--fnumber N] [--remove I,J|all] [--move I,J=MM] [--scale I,J=FACTOR]\n"
    "                [--colour I,J=R,G,B] [--weight I,J=W] [--add CENTRE,RADIUS]...\n"
    "      what a flare should look like, for up to 8 lights (default 5,0): the spots of a lens's ghosts, or a target so far, changed in the order\n"
    "      of the options, each of which may be repeated. --move: along the line, to the light's side, at the first light; in proportion at\n"
    "      the others. --add: one of which there is no ghost yet, likewise. A readable text; see THE TARGET FORMAT in lensopt.h\n";

static void print_help_edit(FILE *file) { fputs(help_edit, file); }

/* ---- options ---- */

/* A row and what follows `separator`, NULL if nothing does. */
static int row_and_rest(const char *option, const char *text, char separator, const char **rest)
{
    const char *at = strchr(text, separator);
    char row[32];
    size_t length = at != NULL ? (size_t)(at - text) : strlen(text);
    if (length >= sizeof row) complain("%s: a row of the lens was expected, not '%s'", option, text);
    memcpy(row, text, length);
    row[length] = 0;
    *rest = at != NULL ? at + 1 : NULL;
    return whole_number(option, row, 1, LFLARE_MAX_SURFACES);
}

static void three_numbers(const char *option, const char *text, double *out)
{
    const char *second = strchr(text, ',');
    char first[32];
    if (second == NULL || (size_t)(second - text) >= sizeof first || strchr(second + 1, ',') == NULL) complain("%s: three numbers R,G,B were expected, not '%s'", option, text);
    memcpy(first, text, (size_t)(second - text));
    first[second - text] = 0;
    out[0] = number(option, first, 0, 1e6);
    two_numbers(option, second + 1, ',', 0, 1e6, &out[1], &out[2]);
    if (!(out[0] + out[1] + out[2] > 0)) complain("%s: a colour was expected, which black is not", option);
}

/* 1 if the option was one of these commands'. */
static int edit_option(options *o, const char *command, const char *name, const char *value)
{
    if (strcmp(command, "target") == 0 && strcmp(name, "-o") != 0 && strcmp(name, "--fnumber") != 0) {
        if (o->change_count == MAX_CHANGES) complain("%s: no more than %d options of this kind", name, MAX_CHANGES);
        o->changes[o->change_count][0] = name;
        o->changes[o->change_count++][1] = value;
        return 1;
    }
    if (strcmp(name, "--stop-radius") == 0) o->stop_factor = number(name, value, 0.001, 1000);
    else if (strcmp(name, "--pupil") == 0) o->pupil_factor = number(name, value, 0.001, 1000);
    else if (strcmp(name, "--size") == 0 && strcmp(command, "edit") == 0) o->size_factor = number(name, value, 0.001, 1000);
    else if (strcmp(name, "--surface") == 0) o->mirror = strcmp(value, "both") == 0 ? 0 : whole_number(name, value, 1, LFLARE_MAX_SURFACES);
    else if (strcmp(name, "--target") == 0) three_numbers(name, value, o->target);
    else if (strcmp(name, "--coating") == 0) {
        if (o->coating_count == MAX_COATINGS) complain("--coating: no more than %d at a time", MAX_COATINGS);
        o->coatings[o->coating_count++] = value;
    } else if (strcmp(name, "--move-stop") == 0) {
        const char *fraction;
        o->move_behind = row_and_rest(name, value, ',', &fraction);
        o->move_fraction = fraction != NULL ? number(name, fraction, 0, 1) : 0.5;
    } else {
        return 0;
    }
    return 1;
}

/* Of the round iris at an f-number, 0 being the full opening. */
static double iris_radius(const lflare_lens *lens, double fnumber)
{
    lflare_iris iris;
    if (lflare_iris_make(lens, fnumber, 0, 0, 0, &iris, NULL) != LFLARE_OK) complain("--fnumber: the lens has no such opening");
    return (double)iris.radius;
}

/* ---- flare edit ---- */

/* What was done, for people and for the file's comments. */
typedef struct edit_report {
    char lines[MAX_COATINGS + 8][200];
    int count;
    lflare_lens before, after; /* of the ghost's size */
    lensopt_change *changes;
    int32_t change_count;
} edit_report;

static char *edit_line(edit_report *r) { return r->lines[r->count++]; }

static void edit_derive(const lflare_prescription *p, lflare_lens *lens)
{
    lflare_error error;
    if (lflare_lens_derive(p, lens, &error) != LFLARE_OK) complain("%s", error.text); /* the library has derived it before */
}

static void edit_coating(lflare_prescription *p, const char *text, edit_report *r)
{
    const char *kind, *values;
    lflare_error error;
    lflare_result result;
    int row = row_and_rest("--coating", text, '=', &kind);
    double a, b;
    if (kind == NULL) kind = "";
    values = strchr(kind, ':');
    if (strcmp(kind, "bare") == 0) {
        result = lensopt_coat_bare(p, row - 1, &error);
        sprintf(edit_line(r), "row %d is bare", row);
    } else if (strncmp(kind, "quarter:", 8) == 0) {
        a = number("--coating", values + 1, 100, 20000);
        result = lensopt_coat_quarter(p, row - 1, a, &error);
        sprintf(edit_line(r), "row %d has a quarter-wave coating for %g nm", row, a);
    } else if (strncmp(kind, "layer:", 6) == 0) {
        two_numbers("--coating", values + 1, ',', 0.01, 1e5, &a, &b);
        result = lensopt_coat_layer(p, row - 1, a, b, &error);
        sprintf(edit_line(r), "row %d has one layer of index %g, %g nm thick", row, a, b);
    } else {
        complain("--coating: ROW=quarter:NM, ROW=layer:N,NM or ROW=bare was expected, not '%s'", text);
        return;
    }
    if (result != LFLARE_OK) complain("--coating %s: %s", text, error.text);
}

static const char *radius_text(double radius, char *out)
{
    if (radius == 0) return "flat";
    sprintf(out, "%.6g mm", radius);
    return out;
}

static void edit_size(lflare_prescription *p, const options *o, edit_report *r)
{
    lflare_pair pair = counted_from_0(o->ghost);
    lflare_error error;
    char name[64], was[40], is[40];
    double u = hypot(tan(o->ax * DEGREE), tan(o->ay * DEGREE)), iris;
    lensopt_mirrors mirrors = o->mirror == 0 ? LENSOPT_MIRRORS_BOTH : o->mirror == o->ghost.first ? LENSOPT_MIRRORS_FIRST : LENSOPT_MIRRORS_SECOND;
    int k;
    if (o->mirror != 0 && o->mirror != o->ghost.first && o->mirror != o->ghost.second)
        complain("--surface: %d or %d, which reflect the ghost, or 'both' was expected, not %d", (int)o->ghost.first, (int)o->ghost.second, o->mirror);
    edit_derive(p, &r->before);
    iris = iris_radius(&r->before, o->fnumber);
    if (lensopt_resize_ghost(p, pair, o->size_factor, mirrors, u, iris, &error) != LFLARE_OK)
        complain("--size: %s%s", error.text, error.code == LFLARE_ERROR_ARGUMENT ? "; 'flare ghosts' lists them" : "");
    edit_derive(p, &r->after);
    r->change_count = r->before.ghost_count + r->after.ghost_count;
    r->changes = (lensopt_change *)allocate((size_t)r->change_count, sizeof *r->changes);
    if (lensopt_changes(&r->before, iris, &r->after, iris, u, r->changes, &r->change_count) != LFLARE_OK) complain("out of memory");
    sprintf(edit_line(r), "ghost %s is %g times as large", ghost_name(o->ghost, name), o->size_factor);
    for (k = 0; k < 2; k++) {
        int32_t row = k == 0 ? pair.first : pair.second;
        double a = r->before.prescription.surfaces[row].radius, b = r->after.prescription.surfaces[row].radius;
        if (a != b) sprintf(edit_line(r), "row %d has the radius %s, not %s", (int)row + 1, radius_text(b, is), radius_text(a, was));
    }
}

static void edit_stop(lflare_prescription *p, const options *o, edit_report *r)
{
    static lflare_lens before, after;
    lflare_error error;
    edit_derive(p, &before);
    if (o->stop_factor > 0) {
        if (lensopt_resize_stop(p, o->stop_factor, &error) != LFLARE_OK) complain("--stop-radius: %s", error.text);
        edit_derive(p, &after);
        sprintf(edit_line(r), "the stop is f/%.3g, not f/%.3g: a clear semi-diameter of %.6g, not %.6g mm", after.fnumber, before.fnumber,
                after.prescription.surfaces[after.stop].semi_diameter, before.prescription.surfaces[before.stop].semi_diameter);
    }
    if (o->pupil_factor > 0) {
        if (lensopt_resize_pupil(p, o->pupil_factor, &error) != LFLARE_OK) complain("--pupil: %s", error.text);
        sprintf(edit_line(r), "rows 1 to %d, in front of the stop, have %g times their clear semi-diameter", (int)before.stop, o->pupil_factor);
    }
}

/* Last, since rows are counted anew by it. */
static void edit_move(lflare_prescription *p, const options *o, edit_report *r)
{
    static lflare_lens before, after;
    lensopt_change *changes;
    lflare_error error;
    int32_t count, i, kinds[4] = {0, 0, 0, 0};
    edit_derive(p, &before);
    if (lensopt_move_stop(p, o->move_behind - 1, o->move_fraction, &error) != LFLARE_OK) complain("--move-stop: %s", error.text);
    edit_derive(p, &after);
    count = before.ghost_count + after.ghost_count;
    changes = (lensopt_change *)allocate((size_t)count, sizeof *changes);
    if (lensopt_changes(&before, 1, &after, 1, 0, changes, &count) != LFLARE_OK) complain("out of memory");
    for (i = 0; i < count; i++) kinds[changes[i].there]++;
    free(changes);
    sprintf(edit_line(r), "the stop is row %d, not %d, with a clear semi-diameter of %.6g, not %.6g mm; rows between them are counted anew", (int)after.stop + 1, (int)before.stop + 1,
            after.prescription.surfaces[after.stop].semi_diameter, before.prescription.surfaces[before.stop].semi_diameter);
    sprintf(edit_line(r), "%d ghosts stay, %d are no more, %d are new", (int)kinds[3], (int)kinds[1], (int)kinds[2]);
}

static void edit_table(const edit_report *r, const options *o)
{
    int32_t i;
    printf("\nside effects, light at %g,%g degrees; mm on the sensor along the light's line\n", o->ax, o->ay);
    printf("%5s %6s %10s %10s %10s %10s %8s\n", "first", "second", "centre", "now", "radius", "now", "times");
    for (i = 0; i < r->change_count; i++) {
        const lensopt_change *c = &r->changes[i];
        int its = c->pair_before.first == o->ghost.first - 1 && c->pair_before.second == o->ghost.second - 1;
        if (c->before.radius == 0 && c->after.radius == 0) continue;
        printf("%5d %6d %10.3f %10.3f %10.3f %10.3f ", (int)c->pair_before.first + 1, (int)c->pair_before.second + 1, c->before.centre, c->after.centre, c->before.radius, c->after.radius);
        if (c->before.radius > 0 && c->after.radius > 0) printf("%8.3f%s\n", c->after.radius / c->before.radius, its ? " *" : "");
        else printf("%8s\n", c->after.radius > 0 ? "appears" : "hidden");
    }
    printf("* the one that was asked for; ghosts that are hidden before and after are not listed\n");
}

static void write_edited(const char *path, const lflare_prescription *p, const edit_report *r)
{
    size_t size = 0;
    char *text;
    output *out;
    int i;
    lflare_text_write(p, NULL, &size);
    text = (char *)allocate(size, 1);
    lflare_text_write(p, text, &size);
    out = output_open(path);
    fwrite(text, 1, size, out->file);
    for (i = 0; i < r->count; i++) fprintf(out->file, "# edited: %s\n", r->lines[i]);
    output_close(out);
    free(text);
}

static void edit_check(const options *o)
{
    if (o->out == NULL) complain("flare edit: say where the lens goes, with -o OUT.lens");
    if (o->ghost.first > 0 && !(o->size_factor > 0)) complain("flare edit: say how much larger the ghost is to be, with --size FACTOR");
    if (o->ghost.first == 0 && o->size_factor > 0) complain("flare edit: say which ghost --size means, with --ghost I,J");
    if (o->size_factor == 0 && (o->mirror != 0 || o->fnumber > 0 || o->ax != 0 || o->ay != 0)) complain("flare edit: --surface, --angle and --fnumber belong to --size");
    if (o->size_factor == 0 && o->coating_count == 0 && o->move_behind == 0 && !(o->stop_factor > 0) && !(o->pupil_factor > 0))
        complain("flare edit: say what is to change: --stop-radius, --pupil, --move-stop, --ghost with --size, or --coating");
}

static int command_edit(int argc, char **argv)
{
    static lflare_prescription p;
    static lflare_lens lens;
    static edit_report r;
    options o = parse(argc, argv, " -o --stop-radius --pupil --move-stop --ghost --size --surface --coating --angle --fnumber ", 1);
    lflare_error error;
    char sentence[200];
    int i;
    edit_check(&o);
    if (!import_file(o.operands[0], 0, &p, &lens, &error)) import_complain(o.operands[0], &error);
    for (i = 0; i < o.coating_count; i++) edit_coating(&p, o.coatings[i], &r);
    if (o.size_factor > 0) edit_size(&p, &o, &r);
    edit_stop(&p, &o, &r);
    if (o.move_behind > 0) edit_move(&p, &o, &r);
    edit_derive(&p, &lens);
    write_edited(o.out, &p, &r);
    printf("%s: %d rows, EFL %.4f mm, BFD %.4f mm, f/%.3g, %d ghosts\n", o.out, (int)lens.surface_count, lens.efl, lens.bfd, lens.fnumber, (int)lens.ghost_count);
    for (i = 0; i < r.count; i++) printf("edited    %s\n", r.lines[i]);
    for (i = 0; i < lens.note_count; i++) printf("note      %s\n", lflare_note_text(&lens.notes[i], sentence, sizeof sentence));
    if (r.changes != NULL) edit_table(&r, &o);
    free(r.changes);
    return finish();
}

/* ---- flare colour-map ---- */

enum { MAP_CELL = 3, MAP_SIDE = MAP_CELL * LENSOPT_COLOUR_STEPS, MAP_LEFT = 44, MAP_FOOT = 28, MAP_EDGE = 12, MAP_WIDTH = MAP_LEFT + MAP_SIDE + MAP_EDGE, MAP_HEIGHT = MAP_EDGE + MAP_SIDE + MAP_FOOT };

static void map_dot(uint8_t *rgb, int x, int y, int size, uint8_t grey)
{
    int i, k;
    for (k = 0; k < size; k++)
        for (i = 0; i < size; i++)
            if (x + i >= 0 && x + i < MAP_WIDTH && y + k >= 0 && y + k < MAP_HEIGHT) memset(rgb + 3 * ((y + k) * MAP_WIDTH + x + i), grey, 3);
}

/* Digits of 3 x 5 dots, row by row from the top. */
static void map_number(uint8_t *rgb, int x, int y, int value)
{
    static const uint16_t digits[10] = {075557, 026227, 071747, 071717, 055711, 074717, 074757, 071111, 075757, 075717};
    int place, i;
    for (place = 100; place > 0; place /= 10, x += 8)
        for (i = 0; i < 15; i++)
            if (digits[value / place % 10] >> (14 - i) & 1) map_dot(rgb, x + 2 * (i % 3), y + 2 * (i / 3), 2, 220);
}

/* Places of a wavelength's middle along either axis. */
static int map_x(double nm) { return MAP_LEFT + (int)((nm - LENSOPT_COLOUR_BEGIN) / LENSOPT_COLOUR_STEP * MAP_CELL) + MAP_CELL / 2; }
static int map_y(double nm) { return MAP_EDGE + MAP_SIDE - 1 - (int)((nm - LENSOPT_COLOUR_BEGIN) / LENSOPT_COLOUR_STEP * MAP_CELL) - MAP_CELL / 2; }

static void map_axes(uint8_t *rgb)
{
    int nm, i;
    for (nm = 400; nm <= 750; nm += 50) {
        for (i = 0; i < 6; i++) {
            map_dot(rgb, map_x(nm), MAP_EDGE + MAP_SIDE + i, 1, 220);
            map_dot(rgb, MAP_LEFT - 1 - i, map_y(nm), 1, 220);
        }
        map_number(rgb, map_x(nm) - 11, MAP_EDGE + MAP_SIDE + 10, nm);
        map_number(rgb, MAP_LEFT - 34, map_y(nm) - 5, nm);
    }
}

/* Hues alone, each as bright as it can be shown. */
static void map_cells(uint8_t *rgb, const float *w)
{
    int i, j, c, x, y;
    for (j = 0; j < LENSOPT_COLOUR_STEPS; j++)
        for (i = 0; i < LENSOPT_COLOUR_STEPS; i++, w += 3) {
            float most = brightest(w);
            for (y = 0; y < MAP_CELL; y++)
                for (x = 0; x < MAP_CELL; x++)
                    for (c = 0; c < 3; c++)
                        rgb[3 * ((MAP_EDGE + MAP_SIDE - 1 - MAP_CELL * j - y) * MAP_WIDTH + MAP_LEFT + MAP_CELL * i + x) + c] = (uint8_t)(255 * tone(w[c], most > 0 ? most : 1) + 0.5f);
        }
}

/* A ring, light and dark, so that it shows on any colour. */
static void map_mark(uint8_t *rgb, const lensopt_colour_point *best)
{
    int x, y;
    for (y = -8; y <= 8; y++)
        for (x = -8; x <= 8; x++) {
            int d = x * x + y * y;
            if (d >= 20 && d <= 56) map_dot(rgb, map_x(best->first_nm) + x, map_y(best->second_nm) + y, 1, d < 38 ? 255 : 0);
        }
}

static void print_hue(const char *key, const double *rgb)
{
    double sum = rgb[0] + rgb[1] + rgb[2];
    printf("%-9s %.4f, %.4f, %.4f", key, rgb[0] / sum, rgb[1] / sum, rgb[2] / sum);
}

static void print_best(const options *o, const lensopt_colour_map *map, const lensopt_colour_point *best)
{
    const double *t = o->target, *w = best->rgb;
    double sum = w[0] + w[1] + w[2], were = map->now[0] + map->now[1] + map->now[2];
    print_hue("target", t);
    putchar('\n');
    print_hue("best", w);
    printf(", off by %.4f; %.3g times as bright as now\n", best->distance, were > 0 ? sum / were : 0.0);
    printf("coatings  %g nm on row %d, %g nm on row %d: flare edit %s -o OUT.lens --coating %d=quarter:%g --coating %d=quarter:%g\n", best->first_nm, (int)o->ghost.first, best->second_nm,
           (int)o->ghost.second, o->operands[0], (int)o->ghost.first, best->first_nm, (int)o->ghost.second, best->second_nm);
}

static int command_colour_map(int argc, char **argv)
{
    static lflare_lens lens;
    static lensopt_colour_map map;
    options o = parse(argc, argv, " -o --ghost --angle --fnumber --target --across-stop ", 1);
    double u = hypot(tan(o.ax * DEGREE), tan(o.ay * DEGREE));
    int targeted = o.target[0] + o.target[1] + o.target[2] > 0;
    lensopt_colour_point best;
    char name[64];
    uint8_t *rgb;
    float *w;
    if (o.out == NULL) complain("flare colour-map: say where the picture goes, with -o MAP.png");
    if (!ends_with(o.out, ".png")) complain("%s: a name ending in .png was expected", o.out);
    if (o.ghost.first == 0) complain("flare colour-map: say which ghost, with --ghost I,J; 'flare ghosts' lists them");
    read_lens(o.operands[0], &o.paths, &lens);
    if (lensopt_colour_map_make(&lens, counted_from_0(o.ghost), u, iris_radius(&lens, o.fnumber), &map) != LFLARE_OK)
        complain("--ghost: %s is no ghost of this lens; 'flare ghosts' lists them", ghost_name(o.ghost, name));
    if (targeted && lensopt_colour_best(&map, o.target, 0, &best) != LFLARE_OK) complain("--target: no light comes through, so the ghost has no colour");
    w = (float *)allocate((size_t)LENSOPT_COLOUR_STEPS * LENSOPT_COLOUR_STEPS, 3 * sizeof *w);
    rgb = (uint8_t *)allocate((size_t)MAP_WIDTH * MAP_HEIGHT, 3);
    lensopt_colour_map_floats(&map, w);
    memset(rgb, 24, (size_t)MAP_WIDTH * MAP_HEIGHT * 3);
    map_cells(rgb, w);
    map_axes(rgb);
    if (targeted) map_mark(rgb, &best);
    write_png(o.out, MAP_WIDTH, MAP_HEIGHT, rgb);
    free(rgb);
    free(w);
    printf("%s: hues of ghost %s over the coatings of row %d (to the right) and row %d (upwards), 380 to 750 nm\n", o.out, ghost_name(o.ghost, name), (int)o.ghost.first, (int)o.ghost.second);
    if (map.now[0] + map.now[1] + map.now[2] > 0) print_hue("now", map.now);
    printf("%s\n", map.clip == LFLARE_CLIP_HIDDEN ? "; hidden for this light and iris" : "");
    if (targeted) print_best(&o, &map, &best);
    return finish();
}

/* ---- flare target ---- */

static void target_write(const lensopt_target *t, const char *path)
{
    size_t size = 0;
    output *out;
    char *text;
    lensopt_target_write(t, NULL, &size);
    text = (char *)allocate(size, 1);
    lensopt_target_write(t, text, &size);
    out = output_open(path);
    fwrite(text, 1, size, out->file);
    output_close(out);
    free(text);
}

/* The ghost of a target that I,J names, and what follows '='. */
static lensopt_ghost *target_ghost(lensopt_target *t, const char *option, const char *text, const char **rest)
{
    const char *at = strchr(text, '=');
    char surfaces[64], name[64];
    lflare_pair pair;
    int i;
    if ((at == NULL) != (rest == NULL) || (at != NULL && (size_t)(at - text) >= sizeof surfaces)) complain("%s: %s was expected, not '%s'", option, rest != NULL ? "I,J=VALUE" : "I,J", text);
    sprintf(surfaces, "%.*s", at != NULL ? (int)(at - text) : 63, text);
    pair = counted_from_0(ghost_surfaces(option, surfaces));
    for (i = 0; i < t->ghost_count; i++)
        if (memcmp(&t->ghosts[i].pair, &pair, sizeof pair) == 0) {
            if (rest != NULL) *rest = at + 1;
            return &t->ghosts[i];
        }
    complain("%s: the target has no ghost %s", option, ghost_name(ghost_surfaces(option, surfaces), name));
    return NULL;
}

/* A light's share of what is asked for at the first. */
static double target_share(const lensopt_target *t, int light)
{
    double first = lensopt_slope(&t->lights[0]);
    return first > 0 ? lensopt_slope(&t->lights[light]) / first : 1;
}

static void target_add(lensopt_target *t, const char *option, const char *value)
{
    lensopt_ghost *g;
    double centre, radius;
    int i;
    two_numbers(option, value, ',', -1e4, 1e4, &centre, &radius);
    if (!(radius >= 1e-3)) complain("%s: a radius from 0.001 mm was expected, not %g", option, radius);
    if (t->ghost_count == LENSOPT_MAX_GHOSTS) complain("%s: a target takes %d ghosts", option, LENSOPT_MAX_GHOSTS);
    g = &t->ghosts[t->ghost_count++];
    memset(g, 0, sizeof *g);
    g->pair.first = -1;
    g->weight = 1;
    for (i = 0; i < t->light_count; i++) {
        g->goals[i].centre = centre * target_share(t, i);
        g->goals[i].radius = radius;
    }
}

static void target_remove(lensopt_target *t, const char *option, const char *value)
{
    lensopt_ghost *g;
    if (strcmp(value, "all") == 0) {
        t->ghost_count = 0;
        return;
    }
    g = target_ghost(t, option, value, NULL);
    memmove(g, g + 1, sizeof *g * (size_t)(&t->ghosts[t->ghost_count] - (g + 1)));
    memset(&t->ghosts[--t->ghost_count], 0, sizeof *g);
}

static void target_change(lensopt_target *t, const char *option, const char *value)
{
    const char *rest;
    lensopt_ghost *g;
    double v;
    int i;
    if (strcmp(option, "--add") == 0) target_add(t, option, value);
    else if (strcmp(option, "--remove") == 0) target_remove(t, option, value);
    else {
        g = target_ghost(t, option, value, &rest);
        if (strcmp(option, "--colour") == 0) three_numbers(option, rest, g->color);
        else if (strcmp(option, "--weight") == 0) g->weight = number(option, rest, 0, 1e6);
        else {
            int move = strcmp(option, "--move") == 0;
            v = move ? number(option, rest, -1e4, 1e4) : number(option, rest, 1e-3, 1e3);
            for (i = 0; i < t->light_count; i++)
                if (g->goals[i].wish == LENSOPT_SPOT) {
                    if (move) g->goals[i].centre += v * target_share(t, i);
                    else g->goals[i].radius *= v;
                }
        }
    }
}

/* A target so far, or a lens's. */
static void target_begin(const options *o, lensopt_target *t)
{
    static lflare_lens lens;
    static lensopt_light lights[LENSOPT_MAX_LIGHTS];
    lflare_error error;
    size_t size;
    int i, count = 0;
    char *text;
    for (i = 0; i < o->change_count; i++) {
        if (strcmp(o->changes[i][0], "--light") != 0) continue;
        if (count == LENSOPT_MAX_LIGHTS) complain("--light: no more than %d lights", LENSOPT_MAX_LIGHTS);
        two_numbers("--light", o->changes[i][1], ',', -89, 89, &lights[count].direction[0], &lights[count].direction[1]);
        lights[count++].weight = 1;
    }
    if (ends_with(o->operands[0], ".target")) {
        if (count > 0 || o->fnumber != 0) complain("%s has its lights and its spots: --light and --fnumber go with a lens", o->operands[0]);
        if (lflare_file_read(o->operands[0], NULL, NULL, &text, &size, &error) != LFLARE_OK) complain("%s: %s", o->operands[0], error.text);
        if (lensopt_target_read(text, size, t, &error) != LFLARE_OK) complain("%s:%d:%d: %s", o->operands[0], (int)error.line, (int)error.column, error.text);
        free(text);
        return;
    }
    if (count == 0) lights[0].direction[0] = 5, lights[0].weight = 1, count = 1;
    read_lens(o->operands[0], &o->paths, &lens);
    if (lensopt_target_of(&lens, lights, count, iris_radius(&lens, o->fnumber), t, &error) != LFLARE_OK) complain("%s: %s", o->operands[0], error.text);
}

static int command_target(int argc, char **argv)
{
    static lensopt_target target;
    options o = parse(argc, argv, " -o --light --fnumber --remove --move --scale --colour --weight --add ", 1);
    lflare_error error;
    int i;
    if (o.out == NULL) complain("flare target: say where it goes, with -o OUT.target");
    if (!ends_with(o.out, ".target")) complain("%s: a name ending in .target was expected", o.out);
    target_begin(&o, &target);
    for (i = 0; i < o.change_count; i++)
        if (strcmp(o.changes[i][0], "--light") != 0) target_change(&target, o.changes[i][0], o.changes[i][1]);
    if (lensopt_target_check(&target, &error) != LFLARE_OK) complain("%s", error.text);
    target_write(&target, o.out);
    printf("%s: %d ghost%s for %d light%s\n", o.out, (int)target.ghost_count, target.ghost_count == 1 ? "" : "s", (int)target.light_count, target.light_count == 1 ? "" : "s");
    return finish();
}
