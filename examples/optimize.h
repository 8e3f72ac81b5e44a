/* Of flare, the command-line tool: lenses searched for the flare that is wanted, with lensopt.h. Included by flare.c alone, behind edit.h,
   whose functions it uses. */

static const char help_optimize[] =
    "  flare optimize TARGET [--base LENS [--fnumber N] [--keep-order] | --scratch [--surfaces N]] -o BEST.lens [--top K]\n"
    "                [--algorithm memetic|pso|jde|de] [--objective seen|matched|thesis] [--time S] [--evaluations N] [--goal F]\n"
    "                [--threads N] [--seed N] [--checkpoint FILE] [--resume FILE] [--picture FILE.png] [--efl LO,HI] [--back-focus LO,HI]\n"
    "                [--length LO,HI] [--fstop LO,HI] [--focus MM] [--edges GLASS[,AIR]] [--glasses all|MAKER[,MAKER...]] [--blind]\n"
    "      a lens searched whose flare comes near to a target (flare target), from a lens or from scratch (the default; as few surfaces as will do,\n"
    "      or N without the stop; spots of one lens tell how many, and it, to the memetic search unless --blind), until S seconds have passed (60, unless evaluations are limited), after N evaluations, or at a value of F or less\n"
    "      (1e-16 where time alone is limited and one lens asked for).\n"
    "      Prints what was wanted and what was got. Ctrl-C or SIGTERM ends it: the best so far is written, the exit status is 130\n"
    "      --fnumber: of the target's iris in LENS; --keep-order: what is air there stays air. The target's locks hold for LENS, too\n"
    "      --top: also BEST-2.lens to BEST-K.lens, the next best whose spots differ from those of all better ones by 1 % or more, or else whose surfaces\n"
    "      differ by 1 % of their ranges\n"
    "      --objective: seen, what shows on the frame, all lights (the value's root is a mean relative difference); matched and thesis: mm^2 at\n"
    "      the first light\n"
    "      --checkpoint: the search as it stands, every 10 s and at the end; --resume goes on from there, with the same target and options\n"
    "      (but for time, evaluations, goal, threads). With one seed, limited by evaluations alone, the lenses are the same to the byte\n"
    "      --picture: the target's spots at the first light to the left, the lens's to the right\n"
    "      --efl, --back-focus, --length (first surface to sensor), --fstop (at the target's iris): ranges, in mm but for the last;\n"
    "      --focus: the image lies that near to the sensor; --edges: least thickness at the edge of what the direct light passes, and least air\n"
    "      there (0.1 mm); --glasses: only those of the catalogue, of all makers or of some, such as SCHOTT,OHARA, and the base's own\n";

static void print_help_optimize(FILE *file) { fputs(help_optimize, file); }

/* ---- options ---- */

static const char *const optimize_methods[] = {"memetic", "de", "jde", "pso"};
static const char *const optimize_objectives[] = {"seen", "matched", "thesis"};

/* Which of `count` words it is. */
static int one_of(const char *option, const char *text, const char *const *words, int count)
{
    char list[100] = "";
    int i;
    for (i = 0; i < count; i++) {
        if (strcmp(text, words[i]) == 0) return i;
        sprintf(list + strlen(list), "%s'%s'", i == 0 ? "" : i + 1 < count ? ", " : " or ", words[i]);
    }
    complain("%s: %s was expected, not '%s'", option, list, text);
    return 0;
}

static void optimize_range(const char *option, const char *text, lensopt_range *r)
{
    two_numbers(option, text, ',', 1e-3, 1e6, &r->lo, &r->hi);
    if (r->lo > r->hi) complain("%s: LO,HI was expected, and %g is more than %g", option, r->lo, r->hi);
}

/* 1 if the option was one of this command's. */
static int optimize_option(options *o, const char *command, const char *name, const char *value)
{
    optimize_options *s = &o->optimize;
    if (strcmp(command, "optimize") != 0) return 0;
    if (strcmp(name, "--base") == 0) s->base = value;
    else if (strcmp(name, "--resume") == 0) s->resume = value;
    else if (strcmp(name, "--checkpoint") == 0) s->checkpoint = value;
    else if (strcmp(name, "--picture") == 0) s->picture = value;
    else if (strcmp(name, "--glasses") == 0) s->glasses = value;
    else if (strcmp(name, "--algorithm") == 0) s->method = (lensopt_method)one_of(name, value, optimize_methods, 4);
    else if (strcmp(name, "--objective") == 0) s->objective = (lensopt_objective)one_of(name, value, optimize_objectives, 3);
    else if (strcmp(name, "--surfaces") == 0) s->surfaces = whole_number(name, value, 2, LENSOPT_MAX_SEARCHED);
    else if (strcmp(name, "--threads") == 0) s->threads = whole_number(name, value, 1, LENSOPT_MAX_THREADS);
    else if (strcmp(name, "--top") == 0) s->top = whole_number(name, value, 1, 100);
    else if (strcmp(name, "--time") == 0) s->time = number(name, value, 0.01, 1e8);
    else if (strcmp(name, "--goal") == 0) s->goal = number(name, value, 1e-300, 1e300);
    else if (strcmp(name, "--focus") == 0) s->focus = number(name, value, 1e-3, 1e6);
    else if (strcmp(name, "--efl") == 0) optimize_range(name, value, &s->efl);
    else if (strcmp(name, "--back-focus") == 0) optimize_range(name, value, &s->back_focus);
    else if (strcmp(name, "--length") == 0) optimize_range(name, value, &s->length);
    else if (strcmp(name, "--fstop") == 0) optimize_range(name, value, &s->fstop);
    else if (strcmp(name, "--evaluations") == 0) {
        double count = number(name, value, 1, 1e15);
        if (count != floor(count)) complain("%s: a whole number was expected, not '%s'", name, value);
        s->evaluations = (int64_t)count;
    } else if (strcmp(name, "--edges") == 0) {
        s->edges[1] = 0.1;
        if (strchr(value, ',') != NULL) two_numbers(name, value, ',', 0, 1e4, &s->edges[0], &s->edges[1]);
        else s->edges[0] = number(name, value, 0, 1e4);
    } else if (strcmp(name, "--seed") == 0) {
        s->has_seed = 1;
        o->seed = whole_number(name, value, 0, 1000000000);
    } else {
        return 0;
    }
    return 1;
}

static void optimize_check(const options *o)
{
    const optimize_options *s = &o->optimize;
    if (o->out == NULL) complain("flare optimize: say where the lens goes, with -o BEST.lens");
    if (s->base != NULL && s->scratch) complain("flare optimize: --base or --scratch, not both");
    if (s->base != NULL && s->surfaces > 0) complain("flare optimize: --surfaces belongs to --scratch; a base keeps its number of surfaces");
    if (s->base == NULL && (s->keep_order || o->fnumber > 0)) complain("flare optimize: --keep-order and --fnumber belong to --base LENS");
    if (s->back_focus.lo > 0 && s->length.hi > 0 && s->back_focus.lo > s->length.hi)
        complain("flare optimize: no lens has a back focus from %g mm and a length of at most %g", s->back_focus.lo, s->length.hi);
    if (s->picture != NULL && !ends_with(s->picture, ".png")) complain("%s: a name ending in .png was expected", s->picture);
    if (s->checkpoint != NULL && strcmp(s->checkpoint, o->out) == 0) complain("flare optimize: -o and --checkpoint name the same file");
}

/* ---- the job ---- */

/* A spot that stands for a ghost of the target; or one too many. */
typedef struct optimize_spot {
    double centre, radius, cost; /* radius 0: hidden */
    double real_radius;          /* in the lens with its rims, the area's as a circle's */
    double real_centre;
    int there;
} optimize_spot;

/* One of the lenses found. */
typedef struct optimize_found {
    double f, iris, fnumber;
    const double *x;             /* its point */
    optimize_spot *spots;        /* of ghost g at light l: spots[l * ghosts + g] */
    lensopt_shown *shown;        /* all, at the first light */
    lensopt_spot *real;          /* the same with rims */
    int32_t shown_count;
    lflare_lens lens;
} optimize_found;

typedef struct optimize_job {
    const options *o;
    lensopt_target target;
    lensopt_problem *problem;
    lensopt_search *search;
    lensopt_function function;
    int lights;                  /* that the objective knows */
    int terminal, shown;
    double began, told;
    int64_t evaluations_before;
    output checkpoint;           /* where it goes */
    uint8_t *state;
    size_t state_size;
    lensopt_progress last;
    double *points;              /* the best, when it has ended */
} optimize_job;

static void optimize_read_target(const char *path, lensopt_target *t)
{
    lflare_error error;
    size_t size;
    char *text;
    errno = 0;
    if (lflare_file_read(path, NULL, NULL, &text, &size, &error) != LFLARE_OK) complain("%s: %s", path, errno != 0 ? strerror(errno) : error.text);
    if (lensopt_target_read(text, size, t, &error) != LFLARE_OK) {
        fprintf(stderr, "%s:%d:%d: %s\n", path, (int)error.line, (int)error.column, error.text);
        exit(2);
    }
    free(text);
}

/* Whether a maker is named in a list with commas. */
static int optimize_names(const char *list, const char *maker)
{
    size_t size = strlen(maker);
    const char *at = list;
    while ((at = strstr(at, maker)) != NULL && ((at > list && at[-1] != ',') || (at[size] != ',' && at[size] != 0))) at++;
    return at != NULL && size > 0;
}

/* The catalogue's glasses of the makers that are asked for; how many. */
static int32_t optimize_glasses(const char *makers, lflare_medium *out)
{
    char known[200] = "";
    const char *at = makers;
    lensimport_glass glass;
    int32_t i, count = 0, all = strcmp(makers, "all") == 0;
    for (i = 0; i < lensimport_glass_count(); i++) {
        if (lensimport_glass_get(i, &glass) != LFLARE_OK || glass.maker[0] == 0) continue;
        if (!optimize_names(known, glass.maker) && strlen(known) + sizeof glass.maker + 1 < sizeof known) sprintf(known + strlen(known), "%s%s", known[0] != 0 ? "," : "", glass.maker);
        if ((all || optimize_names(makers, glass.maker)) && count < LENSOPT_MAX_GLASSES) out[count++] = glass.medium;
    }
    while (!all && at != NULL) { /* each of the names */
        char name[sizeof glass.maker];
        size_t size = strcspn(at, ",");
        sprintf(name, "%.*s", (int)(size < sizeof name ? size : sizeof name - 1), at);
        if (size >= sizeof name || !optimize_names(known, name)) complain("--glasses: 'all' or makers of the catalogue (%s) were expected, not '%s'", known, makers);
        at = at[size] == ',' ? at + size + 1 : NULL;
    }
    return count;
}

static void optimize_create(optimize_job *job)
{
    static lflare_medium glasses[LENSOPT_MAX_GLASSES];
    static lflare_prescription base;
    static lflare_lens lens;
    const options *o = job->o;
    const optimize_options *s = &o->optimize;
    lensopt_problem_desc d;
    lensopt_search_desc search;
    lflare_error error;
    double start[2 * LENSOPT_MAX_VARIABLES];
    memset(&d, 0, sizeof d);
    memset(&search, 0, sizeof search);
    d.target = &job->target;
    d.objective = s->objective;
    d.surfaces = s->surfaces;
    d.keep_order = s->keep_order;
    d.blind = s->blind || s->method != LENSOPT_MEMETIC; /* their populations are too large to be read */
    d.efl = s->efl;
    d.back_focus = s->back_focus;
    d.length = s->length;
    d.fnumber = s->fstop;
    d.focus = s->focus;
    d.glass_edge = s->edges[0];
    d.air_edge = s->edges[1];
    if (s->glasses != NULL) {
        d.glasses = glasses;
        d.glass_count = optimize_glasses(s->glasses, glasses);
    }
    if (s->base != NULL) {
        if (!import_file(s->base, 0, &base, &lens, &error)) import_complain(s->base, &error);
        d.base = &base;
        d.iris = iris_radius(&lens, o->fnumber);
    }
    if (lensopt_problem_create(&d, &job->problem, &error) != LFLARE_OK) complain("flare optimize: %s", error.text);
    lensopt_problem_function(job->problem, &job->function);
    if (s->base != NULL) {
        double *near_base = start + job->function.variables, value; /* downhill from it: often all that is asked for */
        if (lensopt_problem_point(job->problem, &base, d.iris, start, &error) != LFLARE_OK) complain("%s: %s", s->base, error.text);
        memcpy(near_base, start, sizeof *start * (size_t)job->function.variables);
        job->function.evaluate(job->function.user, near_base, 1, &value);
        job->function.polish(job->function.user, near_base, &value, 200);
        search.starts = start;
        search.start_count = 2;
    }
    search.function = job->function;
    search.method = s->method;
    search.seed = (uint64_t)o->seed;
    search.threads = s->threads;
    if (lensopt_search_create(&search, &job->search, &error) != LFLARE_OK) complain("flare optimize: %s", error.text);
    job->lights = s->objective == LENSOPT_SEEN ? job->target.light_count : 1;
}

static void optimize_resume(optimize_job *job)
{
    const char *path = job->o->optimize.resume;
    lflare_error error;
    size_t size;
    char *bytes;
    errno = 0;
    if (lflare_file_read(path, NULL, NULL, &bytes, &size, &error) != LFLARE_OK) complain("%s: %s", path, errno != 0 ? strerror(errno) : error.text);
    if (lensopt_search_load(job->search, bytes, size, &error) != LFLARE_OK) complain("%s: %s", path, error.text);
    free(bytes);
}

/* ---- files, while it runs ---- */

/* BEST-2.lens of BEST.lens. */
static char *optimize_name(const char *out, int rank)
{
    size_t length = strlen(out) - (ends_with(out, ".lens") ? 5 : 0);
    char *name = (char *)allocate(strlen(out) + 16, 1);
    if (rank == 1) strcpy(name, out);
    else sprintf(name, "%.*s-%d%s", (int)length, out, rank, out + length);
    return name;
}

/* Whether it can be written, by a trial of the part that becomes it. */
static void optimize_try(const char *path)
{
    char blanks[32768];
    output place, *out;
    int bad;
    memset(&place, 0, sizeof place);
    memset(blanks, ' ', sizeof blanks);
    place.path = path;
    output_place(&place);
    if (place.part[0] == 0) return; /* a device has no trial */
    out = output_open(path);
    bad = fwrite(blanks, 1, sizeof blanks, out->file) != sizeof blanks || fflush(out->file) != 0;
    if (bad) complain("%s: cannot be written: %s", path, strerror(errno));
    output_drop();
}

/* The state into its file, which is whole at any moment. Not by output_open: an interrupt must not lose the search. 0, or errno. */
static int optimize_keep(optimize_job *job)
{
    const output *place = &job->checkpoint;
    size_t size = job->state_size;
    FILE *file;
    int why = 0;
    if (lensopt_search_save(job->search, job->state, &size) != LFLARE_OK) return EINVAL;
    errno = 0;
    file = fopen(place->part[0] != 0 ? place->part : place->path, "wb");
    if (file == NULL) return errno;
    if (fwrite(job->state, 1, size, file) != size) why = errno;
    if (fclose(file) != 0 && why == 0) why = errno;
    if (why == 0 && place->part[0] != 0 && replace(place->part, place->target) != 0) why = errno;
    if (why != 0 && place->part[0] != 0) remove(place->part);
    return why;
}

static void optimize_prepare_files(optimize_job *job)
{
    const optimize_options *s = &job->o->optimize;
    int i, why;
    for (i = 1; i <= s->top; i++) {
        char *name = optimize_name(job->o->out, i);
        optimize_try(name);
        free(name);
    }
    if (s->picture != NULL) optimize_try(s->picture);
    if (s->checkpoint == NULL) return;
    job->checkpoint.path = s->checkpoint;
    output_place(&job->checkpoint);
    lensopt_search_save(job->search, NULL, &job->state_size);
    job->state = (uint8_t *)allocate(job->state_size, 1);
    if ((why = optimize_keep(job)) != 0) complain("%s: cannot be written: %s", s->checkpoint, strerror(why));
}

/* ---- the search ---- */

static const char *optimize_count(double count, char *out)
{
    if (count >= 1e9) sprintf(out, "%.3gG", count * 1e-9);
    else if (count >= 1e6) sprintf(out, "%.3gM", count * 1e-6);
    else if (count >= 1e4) sprintf(out, "%.3gk", count * 1e-3);
    else sprintf(out, "%.0f", count);
    return out;
}

static const char *optimize_value(const optimize_job *job, double f, char *out)
{
    int n = sprintf(out, "%.4g", f);
    if (job->o->optimize.objective == LENSOPT_SEEN) sprintf(out + n, " (%.3g %%)", 100 * sqrt(f));
    return out;
}

/* Seconds till a limit ends it; negative: unknown. */
static double optimize_rest(const optimize_job *job, int64_t evaluations, double spent)
{
    const optimize_options *s = &job->o->optimize;
    double left = s->time > 0 ? fmax(0, s->time - spent) : -1;
    if (s->evaluations > 0 && evaluations > job->evaluations_before) {
        double until = (double)(s->evaluations - evaluations) * spent / (double)(evaluations - job->evaluations_before);
        if (left < 0 || until < left) left = fmax(0, until);
    }
    return left;
}

static int32_t optimize_progress(void *user, const lensopt_progress *p)
{
    optimize_job *job = (optimize_job *)user;
    double spent = seconds() - job->began, rest = optimize_rest(job, p->evaluations, spent);
    char line[300], a[24], b[24], c[48];
    int n;
    if (interrupted) return 1;
    if (spent - job->told < (job->terminal ? 0.3 : 10) || !(p->best < HUGE_VAL)) return 0;
    job->told = spent;
    n = sprintf(line, "%.0f s: %s evaluations, %s/s, best %s, diversity %.2g, %s restarts", spent, optimize_count((double)p->evaluations, a),
                optimize_count((double)(p->evaluations - job->evaluations_before) / spent, b), optimize_value(job, p->best, c), p->diversity, optimize_count((double)p->restarts, c + 24));
    if (rest >= 0) n += sprintf(line + n, ", %s%.0f s left", job->o->optimize.goal > 0 ? "at most " : "about ", rest);
    if (job->terminal) fprintf(stderr, "\r%s%*s", line, job->shown > n ? job->shown - n : 0, "");
    else fprintf(stderr, "%s\n", line);
    fflush(stderr);
    job->shown = n;
    return 0;
}

/* In slices where checkpoints are wanted: where they end does not matter to where it goes. */
static void optimize_run(optimize_job *job)
{
    enum { SLICE = 10 };
    const optimize_options *s = &job->o->optimize;
    lensopt_limits limits;
    lflare_error error;
    double spent = 0;
    int why, goes_on;
    memset(&limits, 0, sizeof limits);
    limits.evaluations = s->evaluations;
    limits.target = s->goal;
    job->terminal = isatty(2);
    lensopt_search_status(job->search, &job->last);
    job->evaluations_before = job->last.evaluations;
    job->began = seconds();
    do {
        limits.seconds = s->time > 0 ? fmax(1e-3, s->time - spent) : 0;
        if (s->checkpoint != NULL && (limits.seconds == 0 || limits.seconds > SLICE)) limits.seconds = SLICE;
        if (lensopt_search_run(job->search, &limits, optimize_progress, job, &error) == LFLARE_ERROR_ARGUMENT) complain("flare optimize: %s", error.text);
        lensopt_search_status(job->search, &job->last);
        spent = seconds() - job->began;
        goes_on = job->last.end == LENSOPT_ENDED_SECONDS && !interrupted && (s->time == 0 || spent < s->time);
        if (s->checkpoint != NULL && (why = optimize_keep(job)) != 0)
            fprintf(stderr, "%sflare: %s: cannot be written: %s%s\n", job->shown && job->terminal ? "\n" : "", s->checkpoint, strerror(why), goes_on ? "; the search goes on" : "");
    } while (goes_on);
    job->last.seconds = spent;
    if (job->terminal && job->shown > 0) fprintf(stderr, "\r%*s\r", job->shown, "");
}

/* ---- what was found ---- */

/* Spots of a point at a light, in *out, to be freed; how many. */
static int32_t optimize_shows(const optimize_job *job, const double *x, int light, lensopt_shown **out)
{
    int32_t count = 0;
    lensopt_problem_shows(job->problem, x, light, NULL, &count);
    *out = (lensopt_shown *)allocate((size_t)count, sizeof **out);
    if (lensopt_problem_shows(job->problem, x, light, *out, &count) != LFLARE_OK) complain("out of memory");
    return count;
}

/* With the rims of its lens. */
static lensopt_spot *optimize_real(const optimize_found *f, const lensopt_shown *shown, int32_t count, double u)
{
    lensopt_spot *out = (lensopt_spot *)allocate((size_t)count, sizeof *out);
    int32_t i;
    for (i = 0; i < count; i++)
        if (lensopt_spots(&f->lens, &shown[i].pair, 1, u, f->iris, &out[i]) != LFLARE_OK) memset(&out[i], 0, sizeof out[i]);
    return out;
}

static void optimize_free(optimize_found *f)
{
    if (f == NULL) return;
    free(f->spots);
    free(f->shown);
    free(f->real);
    free(f);
}

/* NULL and a reason where a point makes no lens. */
static optimize_found *optimize_take(const optimize_job *job, const double *x, double value, lflare_error *error)
{
    optimize_found *f = (optimize_found *)allocate(1, sizeof *f);
    lflare_prescription p;
    int l;
    if (lensopt_problem_prescription(job->problem, x, &p, &f->iris, error) != LFLARE_OK || lflare_lens_derive(&p, &f->lens, error) != LFLARE_OK) {
        optimize_free(f);
        return NULL;
    }
    f->f = value;
    f->x = x;
    f->fnumber = fabs(f->lens.stop_a11) * f->lens.efl / (2 * f->iris);
    f->spots = (optimize_spot *)allocate((size_t)(job->lights * job->target.ghost_count), sizeof *f->spots);
    for (l = 0; l < job->lights; l++) {
        lensopt_shown *shown;
        int32_t i, count = optimize_shows(job, x, l, &shown);
        lensopt_spot *real = optimize_real(f, shown, count, lensopt_slope(&job->target.lights[l]));
        for (i = 0; i < count; i++) {
            optimize_spot *spot;
            if (shown[i].ghost < 0) continue;
            spot = &f->spots[l * job->target.ghost_count + shown[i].ghost];
            spot->there = 1;
            spot->centre = shown[i].centre;
            spot->radius = shown[i].radius;
            spot->cost = shown[i].cost;
            spot->real_centre = real[i].centre;
            spot->real_radius = real[i].radius;
        }
        if (l == 0) {
            f->shown = shown;
            f->real = real;
            f->shown_count = count;
        } else {
            free(shown);
            free(real);
        }
    }
    return f;
}

/* 1 % of the frame's diagonal. */
static double optimize_unit(const lensopt_target *t) { return 0.01 * hypot(t->sensor_width, t->sensor_height); }

/* Between the pictures of two lenses: root mean square of their spots' differences, in spots' sizes. */
static double optimize_distance(const optimize_job *job, const optimize_found *a, const optimize_found *b)
{
    int32_t i, count = job->lights * job->target.ghost_count, n = 0;
    double sum = 0;
    for (i = 0; i < count; i++) {
        const optimize_spot *s = &a->spots[i], *t = &b->spots[i];
        if (!s->there && !t->there) continue;
        n++;
        if (!s->there || !t->there || (s->radius > 0) != (t->radius > 0)) {
            sum += 1;
        } else if (s->radius > 0) {
            double size = 0.5 * (s->radius + t->radius) + optimize_unit(&job->target), dc = s->centre - t->centre, dr = s->radius - t->radius;
            sum += (dc * dc + dr * dr) / (size * size);
        }
    }
    return n > 0 ? sqrt(sum / n) : 0;
}

/* Between two lenses themselves: root mean square of their numbers' differences, in their ranges. */
static double optimize_unlikeness(const optimize_job *job, const optimize_found *a, const optimize_found *b)
{
    const lensopt_function *f = &job->function;
    int32_t i;
    double sum = 0;
    for (i = 0; i < f->variables; i++) {
        double d = f->upper[i] > f->lower[i] ? (a->x[i] - b->x[i]) / (f->upper[i] - f->lower[i]) : 0;
        sum += d * d;
    }
    return sqrt(sum / f->variables);
}

/* The best lenses, each unlike all better ones; how many. */
static int optimize_collect(optimize_job *job, optimize_found **found)
{
    enum { POINTS = 500 };
    int n = job->function.variables, count = 0, k;
    double f[POINTS];
    int32_t points = POINTS, i;
    lflare_error error;
    job->points = (double *)allocate((size_t)n * POINTS, sizeof *job->points);
    lensopt_search_points(job->search, job->points, f, &points);
    error.text[0] = 0;
    for (i = 0; i < points && count < job->o->optimize.top; i++) {
        optimize_found *next = optimize_take(job, job->points + (size_t)i * (size_t)n, f[i], &error);
        if (next == NULL) continue;
        for (k = 0; k < count && (optimize_distance(job, found[k], next) >= 0.01 || optimize_unlikeness(job, found[k], next) >= 0.01); k++) {}
        if (k == count) found[count++] = next;
        else optimize_free(next);
    }
    if (count == 0 && points > 0) complain("flare optimize: none of the %d best points makes a lens: %s", (int)points, error.text);
    return count;
}

/* ---- lenses and words ---- */

static const char *optimize_ended(const optimize_job *job)
{
    switch (job->last.end) {
    case LENSOPT_ENDED_TARGET: return "the goal was reached";
    case LENSOPT_ENDED_EVALUATIONS: return "all evaluations were used";
    case LENSOPT_ENDED_SECONDS: return "the time was over";
    default: return "interrupted";
    }
}

/* What iris shows the flare; "" where the lens's own opening does. */
static const char *optimize_advice(const optimize_found *f, char *out)
{
    double full = f->lens.prescription.surfaces[f->lens.stop].semi_diameter;
    out[0] = 0;
    if (f->iris < full * (1 - 1e-6) && f->fnumber > 0) sprintf(out, ": render with --fnumber %.7g", f->fnumber);
    return out;
}

static void optimize_write(const optimize_job *job, const optimize_found *f, int rank)
{
    const options *o = job->o;
    char *path = optimize_name(o->out, rank), *text, advice[64];
    size_t size = 0;
    output *out;
    lflare_text_write(&f->lens.prescription, NULL, &size);
    text = (char *)allocate(size, 1);
    lflare_text_write(&f->lens.prescription, text, &size);
    out = output_open(path);
    fwrite(text, 1, size, out->file);
    fprintf(out->file, "# found by flare optimize, number %d of its search, for %s\n", rank, o->operands[0]);
    if (o->optimize.base != NULL) fprintf(out->file, "# from %s\n", o->optimize.base);
    else fprintf(out->file, "# from scratch\n");
    fprintf(out->file, "# %s: objective %s, %.9g, %lld evaluations", optimize_methods[o->optimize.method], optimize_objectives[o->optimize.objective], f->f,
            (long long)job->last.evaluations);
    if (o->optimize.has_seed || o->optimize.resume == NULL) fprintf(out->file, ", seed %d", o->seed);
    fprintf(out->file, "\n# iris radius %.9g mm, f/%.4g%s\n", f->iris, f->fnumber, optimize_advice(f, advice));
    output_close(out);
    free(text);
    free(path);
}

static double optimize_length(const lflare_lens *lens)
{
    double length = 0;
    int i;
    for (i = 0; i < lens->surface_count; i++) length += lens->prescription.surfaces[i].thickness;
    return length;
}

static void optimize_print_lens(const optimize_job *job, const optimize_found *f, int rank)
{
    char *name = optimize_name(job->o->out, rank), value[48], advice[64];
    const lflare_lens *lens = &f->lens;
    printf("%s: %s, EFL %.4f mm, f/%.4g, back focus %.4f mm (the sensor at %.4f), length %.4f mm, iris radius %.6g mm%s\n", name, optimize_value(job, f->f, value), lens->efl, f->fnumber,
           lens->bfd, lens->prescription.surfaces[lens->surface_count - 1].thickness, optimize_length(lens), f->iris, optimize_advice(f, advice));
    free(name);
}

static const char *optimize_number(double v, int there, char *out)
{
    if (there) sprintf(out, "%.3f", fabs(v) < 0.0005 ? 0 : v);
    else strcpy(out, "-");
    return out;
}

/* Whether the lens's rims change what the search has reckoned with. */
static int optimize_clipped(const optimize_job *job, double centre, double radius, double real_centre, double real_radius)
{
    double size = radius + optimize_unit(&job->target);
    if (!(radius > 0)) return 0;
    return fabs(radius - real_radius) > 0.02 * size || (real_radius > 0 && fabs(centre - real_centre) > 0.02 * size);
}

/* One ghost at one light; 1 if rims clip it. */
static int optimize_row(const optimize_job *job, const optimize_found *f, int32_t g, int light)
{
    const lensopt_ghost *ghost = &job->target.ghosts[g];
    const lensopt_goal *goal = &ghost->goals[light];
    const optimize_spot *s = &f->spots[light * job->target.ghost_count + g];
    int shared = job->o->optimize.objective != LENSOPT_THESIS && light == 0 && s->there && f->f > 0, wanted = goal->wish == LENSOPT_SPOT, seen = s->there && s->radius > 0;
    int clipped = s->there && optimize_clipped(job, s->centre, s->radius, s->real_centre, s->real_radius);
    char name[64], a[32], b[32], c[32], d[32], e[32], rims[80] = "";
    lflare_pair pair = ghost->pair;
    pair.first++;
    pair.second++;
    if (pair.third > 0) pair.third++, pair.fourth++;
    if (ghost->pair.first < 0) strcpy(name, "made");
    else ghost_name(pair, name);
    if (shared) sprintf(e, "%.2f %%", 100 * s->cost / f->f);
    else strcpy(e, "-");
    if (clipped && s->real_radius > 0) sprintf(rims, " * %.3f at %.3f with rims", s->real_radius, s->real_centre);
    else if (clipped) strcpy(rims, " * hidden by rims");
    printf("%-7s %10s %10s %10s %10s %9s%s%s\n", name, optimize_number(goal->centre, wanted, a), optimize_number(s->centre, seen, b), optimize_number(goal->radius, wanted, c),
           optimize_number(s->radius, seen, d), e, rims, !s->there ? " missing" : goal->wish == LENSOPT_SPOT_HIDDEN ? " hidden is wanted" : !seen ? " hidden" : "");
    return clipped;
}

static void optimize_table(const optimize_job *job, const optimize_found *f)
{
    int32_t g, i, many = 0, seen = 0, clipped = 0;
    double cost = 0;
    int l;
    for (l = 0; l < job->lights; l++) {
        const lensopt_light *light = &job->target.lights[l];
        printf("\nlight at %g,%g degrees; mm on the sensor along the light's line%s\n", light->direction[0], light->direction[1], l == 0 ? "; share: of the value, all lights" : "");
        printf("%-7s %10s %10s %10s %10s %9s\n", "ghost", "centre", "got", "radius", "got", "share");
        for (g = 0; g < job->target.ghost_count; g++) clipped += optimize_row(job, f, g, l);
    }
    for (i = 0; i < f->shown_count; i++) {
        if (f->shown[i].ghost >= 0) continue;
        many++;
        cost += f->shown[i].cost;
        seen += f->real[i].radius > 0 && fabs(f->real[i].centre) - f->real[i].radius < 50 * optimize_unit(&job->target);
    }
    printf("\n");
    if (many > 0) {
        printf("too many  %d ghost%s that the target has not, %d of them seen at the first light", (int)many, many == 1 ? "" : "s", (int)seen);
        if (job->o->optimize.objective != LENSOPT_THESIS && f->f > 0) printf("; share %.2f %%", 100 * cost / f->f);
        printf("\n");
    }
    if (clipped > 0) printf("warning   * %d spot%s where the lens's rims change what was reckoned with by more than 2 %%%s\n", (int)clipped, clipped == 1 ? "" : "s",
                            job->o->optimize.edges[0] > 0 ? "" : "; --edges 1 asks for surfaces that light passes whole");
}

/* ---- picture ---- */

enum { SPOTS_WIDTH = 640 /* of a panel */, SPOTS_GAP = 8 };

typedef struct optimize_panels {
    int width, height;
    float *light, *edges;        /* rgb of both panels; how much of an edge is at a pixel, which is drawn over all */
    const lensopt_target *target;
} optimize_panels;

/* A disc as bright as its light is dense; in pixels. */
static void optimize_disc(optimize_panels *p, int left, double x, double y, double r, const double *color)
{
    double most = fmax(color[0], fmax(color[1], color[2])), shape = fmax(r, 1);
    int x0 = (int)fmax(0, x - shape - 1), x1 = (int)fmin(SPOTS_WIDTH - 1, x + shape + 1), y0 = (int)fmax(0, y - shape - 1), y1 = (int)fmin(p->height - 1, y + shape + 1), i, k, c;
    for (k = y0; k <= y1; k++)
        for (i = x0; i <= x1; i++) {
            double d = shape - hypot(i + 0.5 - x, k + 0.5 - y), light = fmin(fmax(d + 0.5, 0), 1) / (shape * shape);
            int at = k * p->width + left + i;
            for (c = 0; c < 3; c++) p->light[3 * at + c] += (float)(light * (most > 0 ? color[c] / most : 1));
            p->edges[at] = fmaxf(p->edges[at], (float)(1 - fabs(d - 0.5)));
        }
}

/* A spot of either panel: sensor's mm along the light's line, which in the picture lead to the light's side. */
static void optimize_draw(optimize_panels *p, int panel, double centre, double radius, const double *color)
{
    const lensopt_light *light = &p->target->lights[0];
    double right = tan(light->direction[0] * DEGREE), up = tan(light->direction[1] * DEGREE), slope = hypot(right, up), scale = SPOTS_WIDTH / p->target->sensor_width;
    if (!(slope > 0)) right = slope = 1;
    optimize_disc(p, panel * (SPOTS_WIDTH + SPOTS_GAP), 0.5 * SPOTS_WIDTH + centre * right / slope * scale, 0.5 * p->height - centre * up / slope * scale, radius * scale, color);
}

/* So that the middle one of the target's lit pixels is a dark grey. */
static float optimize_exposure(const optimize_panels *p)
{
    float *lit = (float *)allocate((size_t)SPOTS_WIDTH * (size_t)p->height, sizeof *lit), exposure = 1;
    size_t n = 0;
    int x, y;
    for (y = 0; y < p->height; y++)
        for (x = 0; x < SPOTS_WIDTH; x++) {
            float v = brightest(p->light + 3 * (y * p->width + x));
            if (v > 0) lit[n++] = v;
        }
    qsort(lit, n, sizeof *lit, by_value);
    if (n > 0) exposure = 0.12f / lit[n / 2];
    free(lit);
    return exposure;
}

static void optimize_picture(const optimize_job *job, const optimize_found *f)
{
    static const double grey[3] = {1, 1, 1};
    const lensopt_target *t = &job->target;
    optimize_panels p;
    float exposure;
    uint8_t *rgb;
    int32_t i;
    int x, c;
    p.target = t;
    p.width = 2 * SPOTS_WIDTH + SPOTS_GAP;
    p.height = (int)fmin(fmax(SPOTS_WIDTH * t->sensor_height / t->sensor_width, 64), 4 * SPOTS_WIDTH);
    p.light = (float *)allocate((size_t)p.width * (size_t)p.height, 3 * sizeof *p.light);
    p.edges = (float *)allocate((size_t)p.width * (size_t)p.height, sizeof *p.edges);
    rgb = (uint8_t *)allocate((size_t)p.width * (size_t)p.height, 3);
    for (i = 0; i < t->ghost_count; i++)
        if (t->ghosts[i].goals[0].wish == LENSOPT_SPOT) optimize_draw(&p, 0, t->ghosts[i].goals[0].centre, t->ghosts[i].goals[0].radius, t->ghosts[i].color);
    for (i = 0; i < f->shown_count; i++)
        if (f->real[i].radius > 0) optimize_draw(&p, 1, f->real[i].centre, f->real[i].radius, f->shown[i].ghost >= 0 ? t->ghosts[f->shown[i].ghost].color : grey);
    exposure = optimize_exposure(&p);
    for (x = 0; x < p.width * p.height; x++)
        for (c = 0; c < 3; c++) {
            float v = 0.88f * tone(1 - expf(-exposure * p.light[3 * x + c]), 1), edge = 0.12f * fmaxf(p.edges[x], 0);
            int at = x % p.width;
            rgb[3 * x + c] = at >= SPOTS_WIDTH && at < SPOTS_WIDTH + SPOTS_GAP ? 255 : (uint8_t)(255 * (v + edge) + 0.5f);
        }
    write_png(job->o->optimize.picture, p.width, p.height, rgb);
    free(p.light);
    free(p.edges);
    free(rgb);
}

/* ---- flare optimize ---- */

static int optimize_locked(const lensopt_target *t)
{
    int i, any = t->stop_locks;
    for (i = 0; i < LFLARE_MAX_SURFACES; i++) any |= t->locks[i];
    return any != 0;
}

static void optimize_report(const optimize_job *job, optimize_found **found, int count)
{
    const optimize_options *s = &job->o->optimize;
    char a[24], b[24];
    double efl;
    int32_t front, behind;
    int i;
    optimize_print_lens(job, found[0], 1);
    printf("objective %s %.6g\n", optimize_objectives[s->objective], found[0]->f);
    printf("found     %s, %lld evaluations, %s restarts, %.1f s, %s/s: %s\n", optimize_methods[s->method], (long long)job->last.evaluations, optimize_count((double)job->last.restarts, a),
           job->last.seconds, optimize_count((double)(job->last.evaluations - job->evaluations_before) / fmax(job->last.seconds, 1e-3), b), optimize_ended(job));
    if (lensopt_problem_reading(job->problem, &front, &behind, &efl))
        printf("read      the spots are those of lenses of %d surfaces in front of the stop and %d behind it, EFL %.2f mm\n", (int)front, (int)behind, efl);
    optimize_table(job, found[0]);
    if (s->top > 1) printf("\n");
    for (i = 1; i < count; i++) optimize_print_lens(job, found[i], i + 1);
    if (s->base == NULL && optimize_locked(&job->target)) printf("note      the target's locks say nothing without --base\n");
    if (count < s->top) printf("top       %d lens%s found whose spots or surfaces differ, not %d\n", count, count == 1 ? "" : "es", s->top);
}

static int command_optimize(int argc, char **argv)
{
    static optimize_job job;
    options o = parse(argc, argv,
                      " -o --base --scratch --surfaces --algorithm --objective --time --evaluations --goal --threads --seed --top --resume --checkpoint --fnumber --keep-order --blind"
                      " --efl --back-focus --length --fstop --focus --edges --picture --glasses ", 1);
    optimize_found *found[100];
    int count, i, stopped;
    if (o.optimize.top == 0) o.optimize.top = 1;
    if (o.optimize.time == 0 && o.optimize.evaluations == 0) o.optimize.time = 60;
    if (o.optimize.goal == 0 && o.optimize.evaluations == 0 && o.optimize.top == 1) o.optimize.goal = 1e-16; /* nobody sees the rest */
    optimize_check(&o);
    job.o = &o;
    optimize_read_target(o.operands[0], &job.target);
    optimize_create(&job);
    if (o.optimize.resume != NULL) optimize_resume(&job);
    optimize_prepare_files(&job);
    watch_interrupts();
    optimize_run(&job);
    count = optimize_collect(&job, found);
    if (count == 0) end_interrupted();
    stopped = interrupted;
    interrupted = 0; /* what follows is what it asks for */
    for (i = 0; i < count; i++) optimize_write(&job, found[i], i + 1);
    if (o.optimize.picture != NULL) optimize_picture(&job, found[0]);
    optimize_report(&job, found, count);
    if (stopped) fprintf(stderr, "flare: interrupted; the best so far is in %s\n", o.out);
    for (i = 0; i < count; i++) optimize_free(found[i]);
    free(job.state);
    free(job.points);
    lensopt_search_free(job.search);
    lensopt_problem_free(job.problem);
    i = finish();
    return stopped ? 130 : i;
}
