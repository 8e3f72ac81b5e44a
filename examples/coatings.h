/* Of flare, the command-line tool: coatings sought that give a lens's ghosts the colours of a target. Included by flare.c alone, behind
   edit.h, whose functions it uses. */

static const char help_coatings[] =
    "  flare optimize-colour LENS TARGET -o OUT.lens [--layers] [--cemented] [--by-spots] [--brightness W] [--fnumber N] [--from-nothing]\n"
    "                [--time S] [--evaluations N] [--goal F] [--threads N] [--seed N]\n"
    "      coatings sought for LENS that give its ghosts the colours of TARGET (flare target --colour I,J=R,G,B), with a table of both.\n"
    "      Quarter-wave layers for 200 to 750 nm on surfaces that meet air, or --layers: one of any index (1.38 to 1.9) and thickness (25 to\n"
    "      750 nm); --cemented: between glasses, too. What TARGET locks stays. --by-spots: ghosts of TARGET are those of LENS whose spots\n"
    "      are nearest, not those of the same surfaces. --brightness: counts W times, for which colours' sums are irradiances as 'flare target'\n"
    "      writes them. --fnumber: as TARGET was made for. Starts from the coatings of LENS unless --from-nothing. All ghosts have their say:\n"
    "      one that is to change while the others ask to stay needs a --weight in TARGET, those that do not matter have --weight I,J=0\n"
    "      ends where the sum of distances of hues is F (0.0001), after S seconds (10), or at Ctrl-C with the best so far; with --evaluations and\n"
    "      without --time and --goal after N of them and nothing else: then the same seed gives the same bytes whatever the number of threads\n";

static void print_help_coatings(FILE *file) { fputs(help_coatings, file); }

/* Islands this small find the Heliar's coatings in 0.01 s, layers in 0.4 s, and quarter waves on 24 surfaces in 2 s; those that the library
   takes for lenses, eight of 60, need two to ten times as long. */
enum { COATINGS_ISLANDS = 4, COATINGS_POPULATION = 10 };

static struct {
    int layers, cemented, by_spots, from_nothing, threads, has_time, has_goal;
    double brightness, time, goal, evaluations;
} coatings_options;

/* 1 if the option was one without a value of this command. */
static int coatings_flag(const char *command, const char *name)
{
    if (strcmp(command, "optimize-colour") != 0) return 0;
    if (strcmp(name, "--layers") == 0) return coatings_options.layers = 1;
    if (strcmp(name, "--cemented") == 0) return coatings_options.cemented = 1;
    if (strcmp(name, "--by-spots") == 0) return coatings_options.by_spots = 1;
    if (strcmp(name, "--from-nothing") == 0) return coatings_options.from_nothing = 1;
    return 0;
}

static int coatings_option(const char *command, const char *name, const char *value)
{
    if (strcmp(command, "optimize-colour") != 0) return 0;
    if (strcmp(name, "--brightness") == 0) coatings_options.brightness = number(name, value, 0, 1e6);
    else if (strcmp(name, "--threads") == 0) coatings_options.threads = whole_number(name, value, 1, LENSOPT_MAX_THREADS);
    else if (strcmp(name, "--time") == 0) coatings_options.has_time = 1, coatings_options.time = number(name, value, 0.001, 1e7);
    else if (strcmp(name, "--goal") == 0) coatings_options.has_goal = 1, coatings_options.goal = number(name, value, 0, 1e9);
    else if (strcmp(name, "--evaluations") == 0) {
        coatings_options.evaluations = number(name, value, 1, 1e15);
        if (coatings_options.evaluations != floor(coatings_options.evaluations)) complain("--evaluations: a whole number was expected, not '%s'", value);
    } else return 0;
    return 1;
}

/* What is sought for, and what is there before and after. */
typedef struct coatings_work {
    lflare_prescription before, after;
    lflare_lens lens;
    lensopt_target target;
    lensopt_coatings *coatings;
    lensopt_function function;
    lensopt_coated_ghost ghosts[LENSOPT_MAX_GHOSTS];
    double x[LENSOPT_MAX_VARIABLES];
    double was[LENSOPT_MAX_GHOSTS][3], was_off[LENSOPT_MAX_GHOSTS], f_was, f; /* hues of the lens as it is, and distances */
    int32_t rows[LFLARE_MAX_SURFACES], row_count;
    int interrupted;
    lensopt_progress end;
} coatings_work;

static void coatings_open(coatings_work *w, const options *o, double iris)
{
    lensopt_coatings_desc desc;
    lflare_error error;
    memset(&desc, 0, sizeof desc);
    desc.lens = &w->lens;
    desc.target = &w->target;
    desc.iris = iris;
    desc.film = coatings_options.layers ? LENSOPT_FILM_LAYER : LENSOPT_FILM_QUARTER;
    desc.matching = coatings_options.by_spots ? LENSOPT_MATCHING_SPOTS : LENSOPT_MATCHING_PAIRS;
    desc.cemented = coatings_options.cemented;
    desc.brightness = coatings_options.brightness;
    if (lensopt_coatings_create(&desc, &w->coatings, &error) != LFLARE_OK) complain("%s: %s", o->operands[1], error.text);
    lensopt_coatings_function(w->coatings, &w->function);
    w->row_count = lensopt_coatings_surfaces(w->coatings, w->rows);
}

/* The lens's own coatings, which may be none that are sought, by its spots. */
static void coatings_were(coatings_work *w, double iris)
{
    int32_t g, k;
    lensopt_coatings_ghosts(w->coatings, w->x, w->ghosts);
    for (g = 0; g < w->target.ghost_count; g++) {
        const lensopt_coated_ghost *ghost = &w->ghosts[g];
        const double *color = w->target.ghosts[g].color;
        double sum, wanted = color[0] + color[1] + color[2], off = 0;
        lensopt_spot spot;
        if (ghost->light < 0 || lensopt_spots(&w->lens, &ghost->pair, 1, lensopt_slope(&w->target.lights[ghost->light]), iris, &spot) != LFLARE_OK) continue;
        sum = fmax(spot.irradiance[0] + spot.irradiance[1] + spot.irradiance[2], 1e-300);
        for (k = 0; k < 3; k++) {
            w->was[g][k] = spot.irradiance[k] / sum;
            off += (color[k] / wanted - w->was[g][k]) * (color[k] / wanted - w->was[g][k]);
        }
        w->was_off[g] = sqrt(off) + coatings_options.brightness * fabs(log(sum / wanted));
        w->f_was += w->target.ghosts[g].weight * w->was_off[g];
    }
}

static int32_t coatings_progress(void *user, const lensopt_progress *p)
{
    if (*(const int *)user && p->end == LENSOPT_RUNNING) {
        fprintf(stderr, "\roptimize-colour: %.0f s, %.3g after %.0f evaluations, ", p->seconds, p->best, (double)p->evaluations);
        if (p->remaining >= 0) fprintf(stderr, "at most %.0f s left   ", p->remaining);
        else fprintf(stderr, "%.3g a second   ", p->rate);
        fflush(stderr);
    }
    return interrupted;
}

static void coatings_search(coatings_work *w, const options *o)
{
    lensopt_search_desc desc;
    lensopt_limits limits;
    lensopt_search *search;
    lflare_error error;
    int32_t count = 1;
    int terminal = isatty(2), alone = coatings_options.evaluations > 0;
    memset(&desc, 0, sizeof desc);
    desc.function = w->function;
    desc.method = LENSOPT_MEMETIC;
    desc.islands = COATINGS_ISLANDS;
    desc.population = COATINGS_POPULATION;
    desc.seed = (uint64_t)o->seed;
    desc.threads = coatings_options.threads;
    desc.starts = w->x;
    desc.start_count = !coatings_options.from_nothing;
    limits.seconds = coatings_options.has_time ? coatings_options.time : alone ? 0 : 10;
    limits.evaluations = (int64_t)coatings_options.evaluations;
    limits.target = coatings_options.has_goal ? coatings_options.goal : alone ? 0 : 1e-4;
    watch_interrupts();
    if (lensopt_search_create(&desc, &search, &error) != LFLARE_OK || lensopt_search_run(search, &limits, coatings_progress, &terminal, &error) > LFLARE_INCOMPLETE)
        complain("flare optimize-colour: %s", error.text);
    if (terminal) fprintf(stderr, "\r%90s\r", "");
    lensopt_search_status(search, &w->end);
    if (lensopt_search_points(search, w->x, &w->f, &count) != LFLARE_OK || count == 0) end_interrupted(); /* before its first point */
    w->interrupted = w->end.end == LENSOPT_ENDED_STOPPED;
    if (w->interrupted) interrupted = 0; /* what there is is still written */
    lensopt_search_free(search);
}

static const char *coating_text(const lflare_prescription *p, int32_t row, char out[64])
{
    const lflare_surface *s = &p->surfaces[row];
    const lflare_layer *layer = &p->layers[s->coating == LFLARE_COATING_STACK ? s->first_layer : 0];
    if (s->coating == LFLARE_COATING_QUARTER) sprintf(out, "quarter %.5g", s->quarter_nm);
    else if (s->coating == LFLARE_COATING_STACK && s->layer_count == 1) sprintf(out, "layer %.4g, %.4g nm", layer->n, layer->thickness_nm);
    else if (s->coating == LFLARE_COATING_STACK) sprintf(out, "%d layers", (int)s->layer_count);
    else sprintf(out, "bare");
    return out;
}

static void coatings_write(const coatings_work *w, const options *o)
{
    char was[64], is[64], *text;
    size_t size = 0;
    output *out;
    int32_t i;
    lflare_text_write(&w->after, NULL, &size);
    text = (char *)allocate(size, 1);
    lflare_text_write(&w->after, text, &size);
    out = output_open(o->out);
    fwrite(text, 1, size, out->file);
    fprintf(out->file, "# coatings by flare optimize-colour for the colours of a target%s%s\n", w->target.name[0] ? ": " : "", w->target.name);
    fprintf(out->file, "# objective %.6g, was %.6g; seed %d, %.0f evaluations%s\n", w->f, w->f_was, o->seed, (double)w->end.evaluations, w->interrupted ? ", interrupted" : "");
    for (i = 0; i < w->row_count; i++) fprintf(out->file, "# row %d: %s, was %s\n", (int)w->rows[i] + 1, coating_text(&w->after, w->rows[i], is), coating_text(&w->before, w->rows[i], was));
    output_close(out);
    free(text);
}

static const char *hue_text(const double *rgb, char out[64])
{
    double sum = fmax(rgb[0] + rgb[1] + rgb[2], 1e-300);
    sprintf(out, "%.3f %.3f %.3f", rgb[0] / sum, rgb[1] / sum, rgb[2] / sum);
    return out;
}

static void coatings_table(const coatings_work *w)
{
    char a[64], b[64], c[64];
    int32_t i, missing = 0;
    printf("\n%7s  %-20s %s\n", "surface", "coating", "was");
    for (i = 0; i < w->row_count; i++) printf("%7d  %-20s %s\n", (int)w->rows[i] + 1, coating_text(&w->after, w->rows[i], a), coating_text(&w->before, w->rows[i], b));
    printf("\n%5s %6s %5s %7s  %-18s %-18s %-18s %8s %8s%s\n", "first", "second", "light", "weight", "wanted (r g b)", "got", "was", "off", "was", coatings_options.brightness > 0 ? "  brightness" : "");
    for (i = 0; i < w->target.ghost_count; i++) {
        const lensopt_coated_ghost *g = &w->ghosts[i];
        const lensopt_ghost *t = &w->target.ghosts[i];
        double wanted = t->color[0] + t->color[1] + t->color[2];
        missing += g->light < 0 && wanted > 0 && t->weight > 0;
        if (g->light < 0) continue;
        printf("%5d %6d %5d %7.3g  %-18s %-18s %-18s %8.5f %8.5f", (int)g->pair.first + 1, (int)g->pair.second + 1, (int)g->light + 1, t->weight, hue_text(t->color, a), hue_text(g->rgb, b),
               hue_text(w->was[i], c), g->distance, w->was_off[i]);
        if (coatings_options.brightness > 0) printf(" %6.3f times", (g->rgb[0] + g->rgb[1] + g->rgb[2]) * g->scale / wanted);
        putchar('\n');
    }
    if (missing > 0) printf("%d ghosts of the target are none that the lens shows\n", (int)missing);
}

static void coatings_read_target(const char *path, lensopt_target *target)
{
    lflare_error error;
    char *text;
    size_t size;
    errno = 0;
    if (lflare_file_read(path, NULL, NULL, &text, &size, &error) != LFLARE_OK) complain("%s: %s", path, errno != 0 ? strerror(errno) : error.text);
    if (lensopt_target_read(text, size, target, &error) != LFLARE_OK) complain("%s:%d:%d: %s", path, (int)error.line, (int)error.column, error.text);
    free(text);
}

static int command_optimize_colour(int argc, char **argv)
{
    static const char *const ends[] = {"", "the goal is reached", "all evaluations are spent", "the time is over", "interrupted", "interrupted"};
    static coatings_work w;
    options o = parse(argc, argv, " -o --layers --cemented --by-spots --brightness --fnumber --from-nothing --time --evaluations --goal --threads --seed ", 2);
    lflare_error error;
    double iris;
    if (o.out == NULL) complain("flare optimize-colour: say where the lens goes, with -o OUT.lens");
    if (!import_file(o.operands[0], 0, &w.before, &w.lens, &error)) import_complain(o.operands[0], &error);
    coatings_read_target(o.operands[1], &w.target);
    iris = iris_radius(&w.lens, o.fnumber);
    coatings_open(&w, &o, iris);
    lensopt_coatings_read(w.coatings, &w.before, w.x); /* as near as coatings of this kind come */
    coatings_were(&w, iris);
    coatings_search(&w, &o);
    w.after = w.before;
    if (lensopt_coatings_apply(w.coatings, w.x, &w.after, &error) != LFLARE_OK) complain("%s: %s", o.operands[0], error.text);
    lensopt_coatings_ghosts(w.coatings, w.x, w.ghosts);
    coatings_write(&w, &o);
    printf("%s: objective %.6g, was %.6g; %d surfaces\n", o.out, w.f, w.f_was, (int)w.row_count);
    printf("search    %s, %.0f evaluations in %.2f s\n", ends[w.end.end], (double)w.end.evaluations, w.end.seconds);
    if (w.f > 1.001 * w.f_was + 1e-4) printf("note      nearer are the coatings that the lens has, which are of another kind\n");
    coatings_table(&w);
    lensopt_coatings_destroy(w.coatings);
    finish();
    if (!w.interrupted) return 0;
    fprintf(stderr, "flare: interrupted; %s has the best so far\n", o.out);
    return 130;
}
