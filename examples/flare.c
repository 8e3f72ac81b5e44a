/* flare: the command-line tool. Shows the whole library at work: tables of a lens and its ghosts, pictures, coatings.
   `flare --help` lists the commands. Read 00_null.c first for the shortest use of the library, 02_own_renderer.c for
   drawing with code of your own. */

#ifdef __linux__
#define _XOPEN_SOURCE 700 /* realpath and clock_gettime, which C99 alone hides there; elsewhere this would hide more than it shows */
#endif
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#define LENSIMPORT_IMPLEMENTATION
#include "lenses/lensimport.h"
#define LENSOPT_IMPLEMENTATION
#include "lensopt.h"

#include "gl_host.h"
#include "reference.h"
#include "diagram.h"
#include <dirent.h>
#include <errno.h>
#include <time.h>
#ifdef _WIN32
#include <io.h>
#define isatty _isatty
#else
#include <sys/stat.h>
#endif
#ifdef FLARE_HAVE_PNG
#include <png.h>
#endif

#define DEGREE (3.14159265358979323846 / 180)

static const char help[] =
    "flare " "0.1.0" ": lens flares from the prescriptions of real lenses\n"
    "\n"
    "  flare info    LENS [--json] [paths]\n"
    "      name, patent, surfaces, stop, focal length, back focal distance, f-number, ghosts, sensor, and what was derived\n"
    "  flare ghosts  LENS [--angle AX,AY] [--fnumber N] [--csv] [paths]\n"
    "      every ghost: surface pair, matrix elements, images of iris and pupil on the sensor (mm), what clips it, its colour; with\n"
    "      --four its third and fourth surface last, or 0\n"
    "  paths: [--across-stop] [--four]\n"
    "      ghosts across the stop; the 64 strongest of four reflections\n"
    "  flare trace   LENS --ray X,Y [--ghost I,J | I,J,K,L] [--angle AX,AY] [--lambda NM] [--json] [--across-stop]\n"
    "      one exact ray through X,Y (mm) on the plane of the first vertex, along the image's path or that of the ghost I,J, as\n"
    "      'flare ghosts' lists it: every hit, its share of power, the sensor's point, the ray's fate (default: 587.5618 nm)\n"
    "  flare render  LENS -o OUT.png|OUT.pfm [--size WxH] [--angle AX,AY] [--fov DEG] [--fnumber N] [--blades N]\n"
    "                [--rotation DEG] [--curvature 0..1] [--radius MRAD] [--backend software|gl] [--ghosts-only]\n"
    "                [--exposure EV] [--model paraxial|polynomial|traced|reference] [--fit FILE] [--wavelengths N] [--cells N]\n"
    "                [iris options] [paths] [--ringing on|off] [--streak SHARE] [--squeeze S]\n"
    "                [--budget N] [--vertices N] [--pixels N] [--imperfection SHARE]\n"
    "      the flare of one light: ghosts with diffraction's fringes at their edges, starburst, and a horizontal streak if asked\n"
    "      for; --ghosts-only: ghosts with plain edges, as rays have them, unless --ringing on. PNG is tone-mapped; PFM holds linear multiples of the light's irradiance. --backend gl\n"
    "      needs no window: EGL draws, or else OSMesa (the environment's GL_HOST=egl, gpu or osmesa picks one)\n"
    "      --model polynomial: aberrated ghosts, near enough to exact rays, from the fit in FILE or beside the lens (NAME.fit\n"
    "      beside NAME.lens), or from one made on the spot; where there is a fit it is the default, elsewhere paraxial, the quick\n"
    "      model of undistorted ghosts\n"
    "      --model traced: exact rays at every vertex of a mesh, in each frame; no fit needed\n"
    "      --wavelengths: 3 (650, 510, 475 nm) to 32 (400 to 700 nm, CIE 1931) of polynomial and traced ghosts, to 256 of the reference\n"
    "      --budget: the N strongest ghosts; --vertices, --pixels: what they may take of a GPU\n"
    "      --imperfection: elements off the axis by up to that share of their radius (0.001 is good)\n"
    "      --model reference: meshes of exact rays from a point of light, slow; N cells along a side of each ghost's entrance, or\n"
    "      finer and finer until two pictures agree to 52 dB\n"
    "  flare starburst LENS -o OUT.png|OUT.pfm [--size N] [--width MM] [--fnumber N] [--blades N] [--rotation DEG]\n"
    "                [--curvature 0..1] [--radius MRAD] [--exposure EV] [iris options]\n"
    "      what diffraction at the iris makes of a light, N x N pixels (default: 512) of MM on the sensor (default: 200 times the\n"
    "      f-number times 550 nm). PFM holds the share of the light's flux that falls on a square millimetre\n"
    "  iris options: [--softness 0..0.5] [--mask FILE.png|FILE.pfm] [--dust N] [--scratches N] [--grating LINES] [--seed N]\n"
    "      edges that fade over so much of the radius; a grey image of what passes; specks, scratches, lines across the iris\n"
    "  flare fit     LENS -o FILE [paths]\n"
    "      polynomials fitted to exact rays of every ghost, for 'flare render --fit' and for lflare_desc.fit: once per lens\n"
    "  flare diagram LENS -o OUT.svg [--ghost I,J | I,J,K,L] [--rays N] [--angle AX,AY] [--across-stop]\n"
    "      the lens in cross-section, with N (default: 5) exact rays of the image and of the ghost I,J, its mirrors and the\n"
    "      entrance heights that it takes; drawn in the plane of the axis and the light\n"
    "  flare compare A B [--json]\n"
    "      PSNR, SSIM and largest error of picture B against picture A (PFM, or PNG where built with libpng)\n"
    "  flare coating N1 N2 [--lambda0 NM | --layers n:nm,...] [--angle DEG] [--csv]\n"
    "      reflectance of a surface from 380 to 780 nm\n";

/* ---- complaints ---- */

/* What is being written, if anything: under another name, so that no half-written file is ever left under its own. */
typedef struct output {
    FILE *file;
    const char *path;                /* as the user says it */
    char target[4096], part[4096];   /* where its links lead; what is renamed to that, "" for a device or a pipe, written as it is */
} output;

static output unfinished;

static void output_drop(void)
{
    if (unfinished.file == NULL) return;
    fclose(unfinished.file);
    unfinished.file = NULL;
    if (unfinished.part[0] != 0) remove(unfinished.part);
}

static void complain(const char *format, ...)
{
    va_list list;
    output_drop();
    fputs("flare: ", stderr);
    va_start(list, format);
    vfprintf(stderr, format, list);
    va_end(list);
    fputc('\n', stderr);
    exit(2);
}

static void *allocate(size_t count, size_t size)
{
    void *block = calloc(count > 0 ? count : 1, size);
    if (block == NULL) complain("out of memory");
    return block;
}

/* SIGINT and SIGTERM only set this: whoever works long looks at it and cleans up. */
static volatile sig_atomic_t interrupted;

static void interrupt(int number)
{
    signal(number, interrupt); /* some systems reset it */
    interrupted = 1;
}

static void watch_interrupts(void)
{
    signal(SIGINT, interrupt);
    signal(SIGTERM, interrupt);
}

static void end_interrupted(void)
{
    output_drop();
    fputs("flare: interrupted; nothing was written\n", stderr);
    exit(130);
}

static double seconds(void)
{
#ifdef _WIN32
    return (double)clock() / CLOCKS_PER_SEC; /* of the wall there */
#else
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
#endif
}

/* Percents of long work, where someone looks. */
typedef struct progress {
    char what[32];
    int terminal, shown;
    double began;
} progress;

static void progress_begin(progress *p)
{
    p->terminal = isatty(2);
    p->shown = -1;
    p->began = seconds();
    watch_interrupts();
}

static void progress_show(void *user, double done)
{
    progress *p = (progress *)user;
    double spent = seconds() - p->began, left = done > 0 ? spent * (1 - done) / done : 0;
    int percent = (int)(100 * done);
    if (!p->terminal || percent == p->shown) return;
    p->shown = percent;
    fprintf(stderr, "\r%s: %d %%, about %.0f s left   ", p->what, percent, left);
    fflush(stderr);
}

static void progress_end(const progress *p)
{
    if (p->terminal) fprintf(stderr, "\r%60s\r", "");
}

/* Standard output may be a full disk. */
static int finish(void)
{
    if (fflush(stdout) != 0 || ferror(stdout)) complain("the output cannot be written: %s", strerror(errno));
    return 0;
}

/* ---- command line ---- */

#define PATH_OPTIONS "--across-stop --four "
enum { FOUR = 64 /* ghosts that --four keeps */, MAX_COATINGS = 32 /* of one flare edit */, MAX_CHANGES = 256 /* of a target */ };

typedef struct optimize_options { /* of flare optimize; 0 or NULL: not asked for */
    const char *base, *resume, *checkpoint, *picture, *glasses;
    lensopt_method method;
    lensopt_objective objective;
    int scratch, keep_order, blind, surfaces, threads, top, has_seed;
    int64_t evaluations;
    double time, goal, focus, edges[2];
    lensopt_range efl, back_focus, length, fstop;
} optimize_options;

typedef struct options {
    const char *operands[2];
    int operand_count;
    const char *out, *layers, *fit, *mask, *catalogue;
    int focus;
    lflare_model model; /* AUTO where `reference` is set, too */
    int json, csv, ghosts_only, gl, reference, wavelengths, cells, has_radius, rays, dust, scratches, grating, seed, ringing, budget, vertices, pixels;
    int width, height, blades, has_ray;
    lflare_pair ghost;  /* surfaces from 1, 0 for none */
    lflare_paths paths;
    double ray[2], lambda;
    const char *coatings[MAX_COATINGS], *changes[MAX_CHANGES][2]; /* changes: options and values, in order */
    int change_count;
    int coating_count, mirror, move_behind; /* rows from 1, 0 for none */
    double stop_factor, pupil_factor, size_factor, move_fraction, target[3]; /* 0: not asked for */
    double ax, ay, fov, fnumber, rotation, curvature, radius, exposure, lambda0, angle, softness, streak, squeeze, sensor_width, imperfection;
    optimize_options optimize;
} options;

static double number(const char *option, const char *text, double lo, double hi)
{
    double value;
    if (!lflare_number_read(text, strlen(text), &value) || !(value >= lo && value <= hi))
        complain("%s: a number from %g to %g was expected, not '%s'", option, lo, hi, text);
    return value;
}

/* Two numbers joined by `separator`. */
static void two_numbers(const char *option, const char *text, char separator, double lo, double hi, double *a, double *b)
{
    const char *at = strchr(text, separator);
    char first[64];
    if (at == NULL || (size_t)(at - text) >= sizeof first) complain("%s: two numbers joined by '%c' were expected, not '%s'", option, separator, text);
    memcpy(first, text, (size_t)(at - text));
    first[at - text] = 0;
    *a = number(option, first, lo, hi);
    *b = number(option, at + 1, lo, hi);
}

/* Two or four surfaces as `flare ghosts` prints them, from 1. */
static lflare_pair ghost_surfaces(const char *option, const char *text)
{
    double v[4] = {0, 0, 0, 0};
    const char *rest = strchr(text, ',');
    lflare_pair pair;
    char first[64];
    int i;
    rest = rest != NULL ? strchr(rest + 1, ',') : NULL;
    if (rest != NULL && (size_t)(rest - text) < sizeof first) {
        memcpy(first, text, (size_t)(rest - text));
        first[rest - text] = 0;
        two_numbers(option, first, ',', 1, LFLARE_MAX_SURFACES, &v[0], &v[1]);
        two_numbers(option, rest + 1, ',', 1, LFLARE_MAX_SURFACES, &v[2], &v[3]);
    } else {
        two_numbers(option, text, ',', 1, LFLARE_MAX_SURFACES, &v[0], &v[1]);
    }
    for (i = 0; i < 4; i++)
        if (v[i] != floor(v[i])) complain("%s: two surface numbers were expected, or four, not '%s'", option, text);
    pair.first = (int32_t)v[0];
    pair.second = (int32_t)v[1];
    pair.third = (int32_t)v[2];
    pair.fourth = (int32_t)v[3];
    return pair;
}

/* The same from 0, as the library counts. */
static lflare_pair counted_from_0(lflare_pair p)
{
    p.first--;
    p.second--;
    if (p.third > 0) p.third--, p.fourth--;
    return p;
}

/* A ghost's surfaces as they are given and printed, "4,2". */
static const char *ghost_name(lflare_pair p, char *out)
{
    int n = sprintf(out, "%d,%d", (int)p.first, (int)p.second);
    if (p.third > 0) sprintf(out + n, ",%d,%d", (int)p.third, (int)p.fourth);
    return out;
}

static int whole_number(const char *option, const char *text, int lo, int hi)
{
    double value = number(option, text, lo, hi);
    if (value != floor(value)) complain("%s: a whole number was expected, not '%s'", option, text);
    return (int)value;
}

/* 1 for the second of two choices, 0 for the first. */
static int second_choice(const char *option, const char *text, const char *first, const char *second)
{
    if (strcmp(text, first) != 0 && strcmp(text, second) != 0) complain("%s: '%s' or '%s' was expected, not '%s'", option, first, second, text);
    return strcmp(text, second) == 0;
}

static void read_model(options *o, const char *option, const char *text)
{
    o->reference = strcmp(text, "reference") == 0;
    o->model = o->reference ? LFLARE_MODEL_AUTO : strcmp(text, "polynomial") == 0 ? LFLARE_MODEL_POLYNOMIAL : strcmp(text, "traced") == 0 ? LFLARE_MODEL_TRACED : LFLARE_MODEL_PARAXIAL;
    if (o->model == LFLARE_MODEL_PARAXIAL && strcmp(text, "paraxial") != 0)
        complain("%s: 'paraxial', 'polynomial', 'traced' or 'reference' was expected, not '%s'", option, text);
}

static int lens_config; /* import.h */
static int edit_option(options *o, const char *command, const char *name, const char *value); /* edit.h */
static void print_help_edit(FILE *file);
static int optimize_option(options *o, const char *command, const char *name, const char *value); /* optimize.h */
static void print_help_optimize(FILE *file);
static int coatings_flag(const char *command, const char *name); /* coatings.h */
static int coatings_option(const char *command, const char *name, const char *value);
static void print_help_coatings(FILE *file);

/* Options whose value is one number, one text, or nothing; `at`: where in options it goes. */
#define AT(member) offsetof(options, member)

static const struct { const char *name; size_t at; double lo, hi; } number_options[] = {
    {"--imperfection", AT(imperfection), 0, 0.1}, {"--softness", AT(softness), 0, 0.5},      {"--streak", AT(streak), 0, 1},          {"--squeeze", AT(squeeze), 0.125, 8},
    {"--width", AT(sensor_width), 1e-6, 1e6},     {"--fov", AT(fov), 0.01, 175},             {"--fnumber", AT(fnumber), 0.1, 1000},   {"--rotation", AT(rotation), -3600, 3600},
    {"--curvature", AT(curvature), 0, 1},         {"--exposure", AT(exposure), -60, 60},     {"--lambda", AT(lambda), 100, 20000},    {"--lambda0", AT(lambda0), 100, 20000}};

static const struct { const char *name; size_t at; int lo, hi; } whole_options[] = {
    {"--dust", AT(dust), 0, LFLARE_MAX_MARKS},  {"--scratches", AT(scratches), 0, LFLARE_MAX_MARKS}, {"--grating", AT(grating), 0, LFLARE_MASK_SIZE / 4},
    {"--seed", AT(seed), 0, 1000000000},        {"--budget", AT(budget), 1, 1000000000},             {"--vertices", AT(vertices), 1, 1000000000},
    {"--pixels", AT(pixels), 1, 1000000000},    {"--wavelengths", AT(wavelengths), 3, REFERENCE_MAX_WAVELENGTHS},
    {"--rays", AT(rays), 0, 101},               {"--cells", AT(cells), 4, 4096}};

static const struct { const char *name; size_t at; } text_options[] = {{"-o", AT(out)}, {"--catalogue", AT(catalogue)}, {"--layers", AT(layers)}, {"--fit", AT(fit)}, {"--mask", AT(mask)}};

static const struct { const char *name; size_t at; int value; } flag_options[] = {
    {"--json", AT(json), 1},           {"--csv", AT(csv), 1},        {"--ghosts-only", AT(ghosts_only), 1}, {"--across-stop", AT(paths.across_stop), 1},
    {"--four", AT(paths.four), FOUR},  {"--scratch", AT(optimize.scratch), 1}, {"--keep-order", AT(optimize.keep_order), 1},
    {"--blind", AT(optimize.blind), 1}};

#define COUNT(table) (sizeof(table) / sizeof(table)[0])

/* 1 if it is an option without a value. */
static int flag_option(options *o, const char *command, const char *name)
{
    char *base = (char *)o;
    size_t k;
    for (k = 0; k < COUNT(flag_options); k++)
        if (strcmp(name, flag_options[k].name) == 0) return *(int *)(void *)(base + flag_options[k].at) = flag_options[k].value;
    if (strcmp(name, "--focus") == 0 && strcmp(command, "convert") == 0) return o->focus = 1;
    return coatings_flag(command, name);
}

/* 1 if it is in one of the tables. */
static int plain_option(options *o, const char *name, const char *value)
{
    char *base = (char *)o;
    size_t k;
    for (k = 0; k < COUNT(number_options); k++)
        if (strcmp(name, number_options[k].name) == 0) {
            *(double *)(void *)(base + number_options[k].at) = number(name, value, number_options[k].lo, number_options[k].hi);
            return 1;
        }
    for (k = 0; k < COUNT(whole_options); k++)
        if (strcmp(name, whole_options[k].name) == 0) {
            *(int *)(void *)(base + whole_options[k].at) = whole_number(name, value, whole_options[k].lo, whole_options[k].hi);
            return 1;
        }
    for (k = 0; k < COUNT(text_options); k++)
        if (strcmp(name, text_options[k].name) == 0) {
            *(const char **)(void *)(base + text_options[k].at) = value;
            return 1;
        }
    return 0;
}

static void blades_option(options *o, const char *name, const char *value)
{
    double blades = number(name, value, 0, LFLARE_MAX_BLADES);
    if (blades != floor(blades) || blades == 1 || blades == 2) complain("--blades: 0 for a round iris or 3 to %d, not '%s'", LFLARE_MAX_BLADES, value);
    o->blades = (int)blades;
}

static void size_option(options *o, const char *command, const char *name, const char *value)
{
    double w, h;
    if (strcmp(command, "starburst") == 0) {
        o->width = o->height = whole_number(name, value, 1, 8192);
        return;
    }
    two_numbers(name, value, 'x', 1, 32768, &w, &h);
    if (w != floor(w) || h != floor(h)) complain("--size: whole numbers of pixels were expected, not '%s'", value);
    o->width = (int)w;
    o->height = (int)h;
}

/* What is in no table. */
static void other_option(options *o, const char *command, const char *name, const char *value)
{
    if (strcmp(name, "--ringing") == 0) o->ringing = 1 + second_choice(name, value, "off", "on");
    else if (strcmp(name, "--model") == 0) read_model(o, name, value);
    else if (strcmp(name, "--backend") == 0) o->gl = second_choice(name, value, "software", "gl");
    else if (strcmp(name, "--radius") == 0) o->has_radius = 1, o->radius = number(name, value, 0, 1000);
    else if (strcmp(name, "--ghost") == 0) o->ghost = ghost_surfaces(name, value);
    else if (strcmp(name, "--ray") == 0) o->has_ray = 1, two_numbers(name, value, ',', -1e6, 1e6, &o->ray[0], &o->ray[1]);
    else if (strcmp(name, "--blades") == 0) blades_option(o, name, value);
    else if (strcmp(name, "--size") == 0) size_option(o, command, name, value);
    else if (strcmp(command, "coating") == 0) o->angle = number(name, value, 0, 89.99);
    else two_numbers(name, value, ',', -89, 89, &o->ax, &o->ay); /* --angle */
}

/* `allowed`: the command's options, each with blanks around it. */
static options parse(int argc, char **argv, const char *allowed, int operands)
{
    const char *command = argv[1];
    options o;
    int i;
    memset(&o, 0, sizeof o);
    o.width = 1280;
    o.height = 720;
    o.blades = -1;
    o.lambda = 587.5618;
    o.rays = 5;
    for (i = 2; i < argc; i++) {
        const char *name = argv[i], *value;
        char key[64];
        if (name[0] != '-' || name[1] == 0 || (name[1] >= '0' && name[1] <= '9')) {
            if (o.operand_count == operands) complain("'%s' is one argument too many for 'flare %s'", name, command);
            o.operands[o.operand_count++] = name;
            continue;
        }
        if (strlen(name) > 40) complain("unknown option '%s'", name);
        sprintf(key, " %s ", name);
        if (strcmp(name, "--config") == 0 && strstr(" compare coating glass ", command) == NULL && i + 1 < argc) {
            lens_config = whole_number(name, argv[++i], 0, 1000);
            continue;
        }
        if (strstr(allowed, key) == NULL) complain("unknown option '%s' for 'flare %s'; see flare --help", name, command);
        if (flag_option(&o, command, name)) continue;
        if (++i == argc) complain("%s: a value is missing", name);
        value = argv[i];
        if (coatings_option(command, name, value) || edit_option(&o, command, name, value) || optimize_option(&o, command, name, value) || plain_option(&o, name, value)) continue;
        other_option(&o, command, name, value);
    }
    if (o.operand_count < operands)
        complain("'flare %s' needs %s; see flare --help", command,
                 strcmp(command, "glass") == 0 ? "a name, or ND,VD" : strcmp(command, "optimize") == 0 ? "a target, which flare target makes" : operands == 1 ? "a lens file" : "two arguments");
    return o;
}

/* ---- lenses ---- */

static void print_number(double v);
static output *output_open(const char *path);
static void output_close(output *o);

#include "import.h"

static void print_json_string(const char *text)
{
    putchar('"');
    for (; *text != 0; text++) {
        if (*text == '"' || *text == '\\') putchar('\\');
        putchar(*text);
    }
    putchar('"');
}

static void print_number(double v)
{
    char text[32];
    int n = (int)lflare_number_write(v, text);
    if (v - v != 0) printf("null");
    else printf("%.*s", n, text);
}

/* Ghosts, of any number of reflections, that have the stop between these. */
static int ghosts_across(const lflare_lens *lens)
{
    int32_t count = lens->ghost_count, g;
    lflare_pair *pairs = (lflare_pair *)allocate((size_t)count, sizeof *pairs);
    int across = 0;
    lflare_ghost_list(lens, pairs, &count);
    for (g = 0; g < count; g++) {
        const lflare_pair *p = &pairs[g];
        int four = p->third > 0, behind = p->first > lens->stop || (four && p->third > lens->stop);
        across += behind && (p->second < lens->stop || (four && p->fourth < lens->stop));
    }
    free(pairs);
    return across;
}

static int command_info(int argc, char **argv)
{
    static lflare_lens lens;
    options o = parse(argc, argv, " --json " PATH_OPTIONS, 1);
    const lflare_prescription *p = &lens.prescription;
    char note[200];
    const char *sentence;
    int i;
    read_lens(o.operands[0], &o.paths, &lens);
    if (o.json) {
        printf("{\"name\": ");
        print_json_string(p->name);
        printf(", \"patent\": ");
        print_json_string(p->patent);
        printf(", \"surfaces\": %d, \"stop\": %d, \"efl_mm\": ", (int)lens.surface_count, (int)lens.stop + 1);
        print_number(lens.efl);
        printf(", \"bfd_mm\": ");
        print_number(lens.bfd);
        printf(", \"fnumber\": ");
        print_number(lens.fnumber);
        printf(", \"ghosts\": %d, \"sensor_mm\": [", (int)lens.ghost_count);
        print_number(lens.sensor_width);
        printf(", ");
        print_number(lens.sensor_height);
        printf("], ");
        if (o.paths.across_stop) printf("\"ghosts_across_stop\": %d, ", ghosts_across(&lens));
        if (o.paths.four > 0) printf("\"ghosts_of_four\": %d, ", (int)lens.four_count);
        printf("\"notes\": [");
        for (i = 0; (sentence = lens_note(&lens, i, note, sizeof note)) != NULL; i++) {
            printf(i > 0 ? ", " : "");
            print_json_string(sentence);
        }
        printf("]}\n");
        return finish();
    }
    printf("name      %s\npatent    %s\n", p->name[0] ? p->name : "-", p->patent[0] ? p->patent : "-");
    if (p->source[0]) printf("source    %s\n", p->source);
    printf("surfaces  %d, the stop counted\nstop      %d\n", (int)lens.surface_count, (int)lens.stop + 1);
    printf("efl_mm    %.4f\nbfd_mm    %.4f\nfnumber   %.3g\nghosts    %d", lens.efl, lens.bfd, lens.fnumber, (int)lens.ghost_count);
    if (o.paths.across_stop) printf(", %d across the stop", ghosts_across(&lens));
    if (o.paths.four > 0) printf(", %d of four reflections", (int)lens.four_count);
    printf("\nsensor_mm %g x %g\n", lens.sensor_width, lens.sensor_height);
    for (i = 0; (sentence = lens_note(&lens, i, note, sizeof note)) != NULL; i++) printf("note      %s\n", sentence);
    return finish();
}

/* One ghost's row: positions in sensor millimetres with their sign, colour in multiples of E. */
typedef struct ghost_row {
    lflare_ghost_matrices m;
    double iris[3], pupil[3], rgb[3];
    const char *clip;
} ghost_row;

static ghost_row ghost_row_make(const lflare_lens *lens, lflare_pair pair, const lflare_iris *iris, const double u[2])
{
    static const char *const clips[] = {"iris", "pupil", "both", "rim", "hidden"};
    static const double nm[4] = {650, 510, 475, 587.5618};
    double slope = hypot(u[0], u[1]);
    ghost_row row;
    lflare_region region;
    lflare_clip clip = lflare_ghost_clip(lens, nm[3], pair, (double)iris->radius, slope, &region);
    int k;
    lflare_ghost_optics(lens, nm[3], &pair, 1, &row.m);
    row.clip = clips[clip];
    for (k = 0; k < 2; k++) {
        row.iris[k] = (row.m.m.b - row.m.m.a * row.m.ma.b / row.m.ma.a) * u[k];
        row.pupil[k] = row.m.m.b * u[k];
    }
    row.iris[2] = fabs(row.m.m.a / row.m.ma.a) * (double)iris->radius;
    row.pupil[2] = fabs(row.m.m.a) * lens->prescription.surfaces[0].semi_diameter;
    for (k = 0; k < 3; k++) {
        lflare_ghost_matrices m;
        lflare_ghost_optics(lens, nm[k], &pair, 1, &m);
        row.rgb[k] = clip == LFLARE_CLIP_HIDDEN ? 0 : lflare_ghost_weight(lens, nm[k], pair, region.centroid, slope) / (m.m.a * m.m.a * sqrt(1 + slope * slope));
    }
    return row;
}

static int command_ghosts(int argc, char **argv)
{
    static lflare_lens lens;
    options o = parse(argc, argv, " --angle --fnumber --csv " PATH_OPTIONS, 1);
    double u[2], effective = 0;
    lflare_iris iris;
    lflare_pair *pairs;
    int32_t count, g;
    read_lens(o.operands[0], &o.paths, &lens);
    u[0] = -tan(o.ax * DEGREE);
    u[1] = -tan(o.ay * DEGREE);
    lflare_iris_make(&lens, o.fnumber, 0, 0, 0, &iris, &effective);
    count = lens.ghost_count;
    pairs = (lflare_pair *)allocate((size_t)count, sizeof *pairs);
    lflare_ghost_list(&lens, pairs, &count);
    if (o.csv) {
        printf("first,second,Ma11,Ma12,M11,M12,iris_x,iris_y,iris_r,pupil_x,pupil_y,pupil_r,clip,r,g,b%s\n", o.paths.four > 0 ? ",third,fourth" : "");
    } else {
        printf("%s, f/%.3g, light at %g,%g degrees: %d ghosts; mm on the sensor; colour in multiples of E\n", lens.prescription.name, effective, o.ax, o.ay,
               (int)count);
        printf("first second     Ma11      Ma12       M11       M12    iris_x    iris_y    iris_r   pupil_x   pupil_y   pupil_r clip          r         g         b%s\n",
               o.paths.four > 0 ? " third fourth" : "");
    }
    for (g = 0; g < count; g++) {
        int third = (int)pairs[g].third + (pairs[g].third > 0), fourth = (int)pairs[g].fourth + (pairs[g].third > 0);
        ghost_row r = ghost_row_make(&lens, pairs[g], &iris, u);
        double v[10];
        int k;
        v[0] = r.m.ma.a; v[1] = r.m.ma.b; v[2] = r.m.m.a; v[3] = r.m.m.b;
        for (k = 0; k < 3; k++) { v[4 + k] = r.iris[k]; v[7 + k] = r.pupil[k]; }
        if (o.csv) {
            printf("%d,%d", (int)pairs[g].first + 1, (int)pairs[g].second + 1);
            for (k = 0; k < 10; k++) { putchar(','); print_number(v[k] + 0.0); }
            printf(",%s", r.clip);
            for (k = 0; k < 3; k++) { putchar(','); print_number(r.rgb[k]); }
            if (o.paths.four > 0) printf(",%d,%d", third, fourth);
        } else {
            printf("%5d %6d", (int)pairs[g].first + 1, (int)pairs[g].second + 1);
            for (k = 0; k < 10; k++) printf(" %9.4g", v[k] + 0.0);
            printf(" %-6s %9.3g %9.3g %9.3g", r.clip, r.rgb[0], r.rgb[1], r.rgb[2]);
            if (o.paths.four > 0) printf(" %5d %6d", third, fourth);
        }
        putchar('\n');
    }
    free(pairs);
    return finish();
}

/* ---- rays ---- */

/* The path of --ghost, or of the image without it. */
static void make_path(const lflare_lens *lens, const options *o, lflare_path *path)
{
    lflare_pair pair = counted_from_0(o->ghost);
    char name[64];
    if (lflare_path_make(lens, o->lambda, o->ghost.first > 0 ? &pair : NULL, path) != LFLARE_OK)
        complain("--ghost: %s is no ghost of this lens; 'flare ghosts' lists them", ghost_name(o->ghost, name));
}

/* A traced ray with what its table and its JSON both say. */
typedef struct traced {
    lflare_path path;
    lflare_ray ray;
    lflare_hit hits[LFLARE_MAX_STEPS];
    double slope[2];
    const char *fate;
    int lost_at;  /* surface from 1 that it misses or that reflects it totally, 0: none */
    int stop_hit; /* index into hits, -1: not reached */
    int blocker;  /* surface from 1 whose rim, or full opening, would stop it, 0: none */
} traced;

static void trace(const lflare_lens *lens, const options *o, traced *t)
{
    static const char *const fates[] = {"arrives", "misses", "total"};
    int i;
    make_path(lens, o, &t->path);
    t->slope[0] = -tan(o->ax * DEGREE);
    t->slope[1] = -tan(o->ay * DEGREE);
    t->fate = fates[lflare_path_trace(&t->path, o->ray, t->slope, &t->ray, t->hits)];
    t->lost_at = t->ray.fate != LFLARE_RAY_ARRIVES && t->ray.steps < t->path.step_count ? (int)t->path.steps[t->ray.steps].surface + 1 : 0;
    t->stop_hit = -1;
    t->blocker = 0;
    for (i = 0; i < t->ray.steps; i++) {
        if (t->path.steps[i].iris) t->stop_hit = i;
        if (t->hits[i].relative > 1 && t->blocker == 0) t->blocker = (int)t->hits[i].surface + 1;
    }
}

static double incidence_of(const lflare_hit *hit) { return acos(fmin(fmax(hit->cosine, 0), 1)) / DEGREE; }

static void print_point(const char *key, const double *v, int there)
{
    printf(", \"%s\": ", key);
    if (!there) { printf("null"); return; }
    putchar('[');
    print_number(v[0]);
    printf(", ");
    print_number(v[1]);
    putchar(']');
}

/* null where the number is 0: surfaces count from 1. */
static void print_surface(const char *key, int surface)
{
    printf(", \"%s\": ", key);
    if (surface > 0) printf("%d", surface);
    else printf("null");
}

static void print_hit_json(const lflare_hit *h)
{
    static const char *const keys[] = {"x", "y", "z", "dx", "dy", "dz", "relative", "incidence_deg", "share"};
    double v[9];
    int k;
    for (k = 0; k < 3; k++) v[k] = h->position[k], v[3 + k] = h->direction[k];
    v[6] = h->relative;
    v[7] = incidence_of(h);
    v[8] = h->share;
    printf("{\"surface\": %d, \"backwards\": %s, \"reflected\": %s", (int)h->surface + 1, h->backwards ? "true" : "false",
           h->reflected ? "true" : "false");
    for (k = 0; k < 9; k++) {
        printf(", \"%s\": ", keys[k]);
        print_number(v[k] + 0.0);
    }
    putchar('}');
}

static void print_trace_json(const lflare_lens *lens, const options *o, const traced *t)
{
    char name[64];
    int i, arrives = t->ray.fate == LFLARE_RAY_ARRIVES;
    printf("{\"name\": ");
    print_json_string(lens->prescription.name);
    printf(", \"ghost\": ");
    if (o->ghost.first > 0) printf("[%s]", ghost_name(o->ghost, name));
    else printf("null");
    printf(", \"lambda_nm\": ");
    print_number(o->lambda);
    print_point("entrance_mm", o->ray, 1);
    print_point("slope", t->slope, 1);
    printf(", \"hits\": [");
    for (i = 0; i < t->ray.steps; i++) {
        if (i > 0) printf(", ");
        print_hit_json(&t->hits[i]);
    }
    putchar(']');
    print_point("sensor_mm", t->ray.sensor, arrives);
    print_point("stop_mm", t->ray.stop, t->stop_hit >= 0);
    printf(", \"weight\": ");
    print_number(arrives ? t->ray.weight : 0);
    print_surface("widest", t->ray.relative > 0 ? (int)t->ray.widest + 1 : 0);
    printf(", \"widest_relative\": ");
    print_number(t->ray.relative);
    printf(", \"fate\": \"%s\"", t->fate);
    print_surface("lost_at", t->lost_at);
    print_surface("blocked_by", t->blocker);
    printf("}\n");
}

static void print_fate(const lflare_lens *lens, const traced *t)
{
    if (t->ray.fate == LFLARE_RAY_TOTAL) printf("fate      totally reflected at surface %d, where it should pass\n", t->lost_at);
    else if (t->ray.fate == LFLARE_RAY_MISSES && t->lost_at > 0) printf("fate      misses surface %d\n", t->lost_at);
    else if (t->ray.fate == LFLARE_RAY_MISSES) printf("fate      misses the sensor\n");
    else if (t->blocker == lens->stop + 1) printf("fate      arrives, but for the stop, which would have to be open wider\n");
    else if (t->blocker > 0) printf("fate      arrives, but for the rim of surface %d, which stops it\n", t->blocker);
    else printf("fate      arrives\n");
}

static void print_trace(const lflare_lens *lens, const options *o, const traced *t)
{
    static const char *const ways[2][2] = {{"->", "->|"}, {"<-", "|<-"}};
    char name[64];
    int i;
    printf("%s, %s%s, %g nm, light at %g,%g degrees, ray through %g,%g mm\n", lens->prescription.name, o->ghost.first > 0 ? "ghost " : "image",
           o->ghost.first > 0 ? ghost_name(o->ghost, name) : "", o->lambda, o->ax, o->ay, o->ray[0], o->ray[1]);
    printf("surface way          x          y          z  height/semi  incidence      share\n");
    for (i = 0; i < t->ray.steps; i++) {
        const lflare_hit *h = &t->hits[i];
        printf("%7d %-3s %10.5f %10.5f %10.5f %12.5f %10.4f %10.4g%s\n", (int)h->surface + 1, ways[h->backwards][h->reflected], h->position[0] + 0.0,
               h->position[1] + 0.0, h->position[2] + 0.0, h->relative, incidence_of(h), h->share, h->surface == lens->stop ? "  the stop" : "");
    }
    if (t->ray.fate == LFLARE_RAY_ARRIVES) printf("sensor    %.6f,%.6f mm\n", t->ray.sensor[0] + 0.0, t->ray.sensor[1] + 0.0);
    if (t->stop_hit >= 0) printf("stop      %.6f,%.6f mm\n", t->ray.stop[0] + 0.0, t->ray.stop[1] + 0.0);
    if (t->ray.fate == LFLARE_RAY_ARRIVES) printf("weight    %.6g of the power\n", t->ray.weight);
    if (t->ray.relative > 0) printf("widest    surface %d, %.4f of its semi-diameter\n", (int)t->ray.widest + 1, t->ray.relative);
    print_fate(lens, t);
}

static int command_trace(int argc, char **argv)
{
    static lflare_lens lens;
    static traced t;
    options o = parse(argc, argv, " --ghost --ray --angle --lambda --json --across-stop ", 1);
    if (!o.has_ray) complain("flare trace: say where the ray enters, with --ray X,Y (mm on the plane of the first vertex)");
    read_lens(o.operands[0], &o.paths, &lens);
    trace(&lens, &o, &t);
    if (o.json) print_trace_json(&lens, &o, &t);
    else print_trace(&lens, &o, &t);
    return finish();
}

/* ---- pictures ---- */

typedef struct picture {
    int width, height;
    float *rgb; /* rows from the top */
} picture;

/* Where to write: fills target and part. */
static void output_place(output *o)
{
    const char *target = o->path;
#ifndef _WIN32
    struct stat there;
    char *real = NULL;
    if (stat(o->path, &there) == 0) {
        if (S_ISDIR(there.st_mode)) complain("%s: cannot be written: %s", o->path, strerror(EISDIR));
        if (!S_ISREG(there.st_mode)) return;
        target = real = realpath(o->path, NULL); /* a link stays one */
        if (real == NULL) complain("%s: cannot be written: %s", o->path, strerror(errno));
    }
#endif
    if (strlen(target) + 6 > sizeof o->part) complain("%s: the path is too long", o->path);
    sprintf(o->target, "%s", target);
    sprintf(o->part, "%s.part", target);
#ifndef _WIN32
    free(real);
#endif
}

/* Until output_close, whatever ends the program removes what was written. */
static output *output_open(const char *path)
{
    output *o = &unfinished;
    memset(o, 0, sizeof *o);
    o->path = path;
    output_place(o);
    watch_interrupts();
    o->file = fopen(o->part[0] != 0 ? o->part : path, "wb");
    if (o->file == NULL) complain("%s: cannot be written: %s", path, strerror(errno));
    return o;
}

static int replace(const char *from, const char *to)
{
#ifdef _WIN32
    remove(to); /* rename does not replace there */
#endif
    return rename(from, to);
}

static void output_close(output *o)
{
    FILE *file = o->file;
    int bad = ferror(file);
    if (interrupted) end_interrupted();
    o->file = NULL;
    if (fclose(file) != 0 || bad || (o->part[0] != 0 && replace(o->part, o->target) != 0)) {
        int why = errno;
        if (o->part[0] != 0) remove(o->part);
        complain("%s: cannot be written: %s", o->path, strerror(why));
    }
}

static void write_pfm(const char *path, const picture *p)
{
    static const uint16_t one = 1;
    output *o = output_open(path);
    int y;
    fprintf(o->file, "PF\n%d %d\n%s\n", p->width, p->height, *(const uint8_t *)&one ? "-1.0" : "1.0");
    for (y = p->height - 1; y >= 0; y--) fwrite(p->rgb + (size_t)3 * (size_t)p->width * (size_t)y, sizeof(float) * 3, (size_t)p->width, o->file);
    output_close(o);
}

static uint32_t crc_of(uint32_t crc, const uint8_t *bytes, size_t n)
{
    size_t i;
    int k;
    crc = ~crc;
    for (i = 0; i < n; i++)
        for (crc ^= bytes[i], k = 0; k < 8; k++) crc = crc & 1 ? 0xedb88320u ^ crc >> 1 : crc >> 1;
    return ~crc;
}

static void put_be32(uint8_t *at, uint32_t v)
{
    at[0] = (uint8_t)(v >> 24);
    at[1] = (uint8_t)(v >> 16);
    at[2] = (uint8_t)(v >> 8);
    at[3] = (uint8_t)v;
}

static void write_chunk(FILE *file, const char *type, const uint8_t *data, uint32_t size)
{
    uint8_t head[8], tail[4];
    uint32_t crc;
    put_be32(head, size);
    memcpy(head + 4, type, 4);
    crc = crc_of(crc_of(0, head + 4, 4), data, size);
    put_be32(tail, crc);
    fwrite(head, 1, 8, file);
    fwrite(data, 1, size, file);
    fwrite(tail, 1, 4, file);
}

/* PNG with stored (uncompressed) blocks, a row each: RFC 1950, 1951; W3C PNG section 11. */
static void write_png(const char *path, int width, int height, const uint8_t *rgb)
{
    static const uint8_t signature[8] = {137, 'P', 'N', 'G', 13, 10, 26, 10};
    uint8_t header[13] = {0}, *row;
    size_t bytes = (size_t)width * 3 + 1;
    uint32_t a = 1, b = 0;
    output *o;
    int y;
    if (bytes > 65535) complain("%s: PNG is limited to 21844 pixels a row here; write a .pfm", path);
    o = output_open(path);
    row = (uint8_t *)allocate(bytes + 16, 1);
    fwrite(signature, 1, 8, o->file);
    put_be32(header, (uint32_t)width);
    put_be32(header + 4, (uint32_t)height);
    header[8] = 8; /* bits */
    header[9] = 2; /* RGB */
    write_chunk(o->file, "IHDR", header, 13);
    for (y = 0; y < height; y++) {
        size_t i, n = 0;
        if (y == 0) { row[n++] = 0x78; row[n++] = 0x01; }
        row[n++] = y == height - 1;
        row[n++] = (uint8_t)bytes;
        row[n++] = (uint8_t)(bytes >> 8);
        row[n++] = (uint8_t)~bytes;
        row[n++] = (uint8_t)(~bytes >> 8);
        row[n] = 0; /* no filter */
        memcpy(row + n + 1, rgb + (size_t)y * (bytes - 1), bytes - 1);
        for (i = 0; i < bytes; i++) {
            a = (a + row[n + i]) % 65521;
            b = (b + a) % 65521;
        }
        n += bytes;
        if (y == height - 1) { put_be32(row + n, b << 16 | a); n += 4; }
        write_chunk(o->file, "IDAT", row, (uint32_t)n);
    }
    write_chunk(o->file, "IEND", row, 0);
    free(row);
    output_close(o);
}

static int ends_with(const char *text, const char *end)
{
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcmp(text + n - m, end) == 0;
}

/* The last frame drawn with GL into floats, and read back into the image: what lflare_render does in software. */
static void render_gl(const lflare *flare, const lflare_image *image)
{
    static gl_host host;
    static char log[2000];
    gl_api gl;
    gl_target target;
    lflare_gl_desc desc = {0};
    lflare_gl *renderer;
    lflare_error error;
    const char *missing;
    if (!gl_host_open(&host, NULL, 0)) complain("--backend gl: %s", host.why);
    missing = gl_api_load(&gl, host.load);
    if (missing != NULL) complain("--backend gl: the GL has no function %s", missing);
    desc.load = host.load;
    desc.log = log;
    desc.log_size = sizeof log;
    desc.models = 1u << lflare_get_tables(flare)->model;
    if (lflare_gl_create(&desc, &renderer, &error) != LFLARE_OK) complain("--backend gl: %s%s%s", error.text, log[0] ? "\n" : "", log);
    if (!gl_target_open(&gl, &target, GL_RGBA32F, image->width, image->height, 0))
        complain("--backend gl: this GL has no float target of %d x %d pixels", image->width, image->height);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    if (lflare_gl_draw(renderer, lflare_get_tables(flare), lflare_get_frame(flare)) != LFLARE_OK ||
        !gl_read_floats(&gl, image->width, image->height, image->pixels))
        complain("--backend gl: the frame cannot be drawn");
    gl_target_close(&gl, &target);
    lflare_gl_destroy(renderer);
    gl_host_close(&host);
}

/* ---- how alike pictures are ---- */

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static float brightest(const float *rgb) { return fmaxf(rgb[0], fmaxf(rgb[1], rgb[2])); }

/* 99.8th percentile of the lit pixels of A (lit: above zero). */
static float white_of(const picture *a)
{
    size_t count = (size_t)a->width * (size_t)a->height, i, n = 0;
    float *lit = (float *)allocate(count, sizeof(float)), white = 1;
    for (i = 0; i < count; i++)
        if (brightest(a->rgb + 3 * i) > 0) lit[n++] = brightest(a->rgb + 3 * i);
    if (n > 0) {
        qsort(lit, n, sizeof(float), by_value);
        white = lit[(size_t)((double)(n - 1) * 0.998)];
    }
    free(lit);
    return white;
}

static float tone(float v, float white) { return powf(fminf(fmaxf(v / white, 0), 1), 1 / 2.2f); }

typedef struct comparison {
    double psnr, psnr_linear, largest; /* dB, infinite where equal */
    float white;
    size_t lit;
} comparison;

/* Picture b against picture a, both of one size, over the pixels that either lights. */
static comparison compare_pictures(const picture *a, const picture *b)
{
    size_t count = (size_t)a->width * (size_t)a->height, i;
    double toned = 0, linear = 0;
    comparison c;
    int k;
    c.white = white_of(a);
    c.lit = 0;
    c.largest = 0;
    for (i = 0; i < count; i++) {
        const float *p = a->rgb + 3 * i, *q = b->rgb + 3 * i;
        if (fmaxf(brightest(p), brightest(q)) <= 1e-4f * c.white) continue;
        c.lit++;
        for (k = 0; k < 3; k++) {
            double d = (double)(p[k] - q[k]), t = (double)(tone(p[k], c.white) - tone(q[k], c.white));
            double l = (double)(fminf(fmaxf(p[k] / c.white, 0), 1) - fminf(fmaxf(q[k] / c.white, 0), 1));
            toned += t * t;
            linear += l * l;
            c.largest = fmax(c.largest, fabs(d));
        }
    }
    c.psnr = c.lit > 0 && toned > 0 ? -10 * log10(toned / (3 * (double)c.lit)) : HUGE_VAL;
    c.psnr_linear = c.lit > 0 && linear > 0 ? -10 * log10(linear / (3 * (double)c.lit)) : HUGE_VAL;
    return c;
}

/* ---- the reference ---- */

/* A lobe of the observer's curves: a bell with two widths. */
/* Three wavelengths are the library's own; more make white what reflects all alike, channel by channel. */
static void set_wavelengths(reference_desc *d, int count)
{
    static const double three[3] = {650, 510, 475};
    double sum[3] = {0, 0, 0};
    int i, k;
    d->wavelengths = count;
    for (i = 0; i < count; i++) {
        d->nm[i] = count == 3 ? three[i] : 400 + 300.0 * i / (count - 1);
        lflare_wavelength_rgb(d->nm[i], d->rgb[i]);
        for (k = 0; k < 3; k++) sum[k] += count == 3 ? d->rgb[i][k] = i == k : d->rgb[i][k];
    }
    for (k = 0; k < 3; k++)
        for (i = 0; i < count; i++) d->rgb[i][k] /= sum[k];
}

/* One picture; ends the program if it was interrupted. */
static void render_mesh(reference_desc *d, int cells, picture *p)
{
    progress seen;
    int result;
    progress_begin(&seen);
    sprintf(seen.what, "%d cells a side", cells);
    d->cells = cells;
    d->progress = progress_show;
    d->user = &seen;
    result = reference_render(d, p->rgb);
    progress_end(&seen);
    if (result == 0) end_interrupted();
    if (result < 0) complain("out of memory");
}

enum { REFERENCE_CELLS = 60, REFERENCE_ROUNDS = 4, REFERENCE_DB = 52 };

/* Finer and finer meshes until two pictures agree; says how well. The finest is left in *p. */
static void render_rounds(reference_desc *d, picture *p)
{
    picture last = *p;
    double cells = REFERENCE_CELLS, db = 0;
    int before = 0, now = 0, turn;
    last.rgb = (float *)allocate((size_t)p->width * (size_t)p->height, 3 * sizeof(float));
    for (turn = 0; turn < REFERENCE_ROUNDS && db < REFERENCE_DB; turn++, cells *= 1.6) {
        float *swap = last.rgb;
        last.rgb = p->rgb;
        p->rgb = swap;
        before = now;
        now = (int)(cells + 0.5);
        render_mesh(d, now, p);
        if (turn > 0) db = compare_pictures(p, &last).psnr;
    }
    free(last.rgb);
    if (db > 1000) fprintf(stderr, "flare: reference: meshes of %d and %d cells a side give the same picture\n", before, now);
    else fprintf(stderr, "flare: reference: meshes of %d and %d cells a side agree to %.1f dB%s\n", before, now, db,
                 db < REFERENCE_DB ? "; --cells takes more" : "");
}

/* The last frame by exact rays, into the image: what lflare_render does by paraxial optics. */
static void render_reference(const lflare *flare, const options *o, const lflare_image *image)
{
    static reference_desc d;
    const lflare_frame_data *frame = lflare_get_frame(flare);
    const lflare_tables *tables = lflare_get_tables(flare);
    size_t count = (size_t)image->width * (size_t)image->height, i;
    picture p;
    int k;
    if (o->has_radius) fprintf(stderr, "flare: --radius has no effect with --model reference: its light is a point\n");
    d.lens = lflare_get_lens(flare);
    d.iris = &tables->iris;
    d.half[0] = (double)frame->half_width;
    d.half[1] = (double)frame->half_height;
    for (k = 0; k < 2; k++) {
        d.slope[k] = (double)frame->lights[0].slope[k];
        d.centre[k] = (double)frame->centre[k];
    }
    d.width = p.width = image->width;
    d.height = p.height = image->height;
    d.stop = &interrupted;
    set_wavelengths(&d, o->wavelengths > 0 ? o->wavelengths : 3);
    p.rgb = (float *)allocate(count, 3 * sizeof(float));
    if (o->cells == 0) {
        render_rounds(&d, &p);
    } else {
        render_mesh(&d, o->cells, &p);
        fprintf(stderr, "flare: reference: a mesh of %d cells a side\n", o->cells);
    }
    for (i = 0; i < 3 * count; i++) image->pixels[i / 3 * 4 + i % 3] = p.rgb[i] * tables->exposure;
    free(p.rgb);
}

/* ---- fits ---- */

static int32_t fit_progress(void *user, int32_t done, int32_t count)
{
    progress_show(user, (double)done / count);
    return interrupted;
}

/* A fit of the lens, from malloc; ends the program if it was interrupted. */
static void *fit_lens(const char *path, const lflare_lens *lens, size_t *size, double *spent)
{
    lflare_aberration_desc desc = {0};
    lflare_error error;
    lflare_result result;
    progress seen;
    void *fit;
    progress_begin(&seen);
    strcpy(seen.what, "fitting");
    desc.progress = fit_progress;
    desc.user = &seen;
    result = lflare_aberration_fit(lens, &desc, &fit, size, &error);
    progress_end(&seen);
    *spent = seconds() - seen.began;
    if (result == LFLARE_INCOMPLETE) end_interrupted();
    if (result != LFLARE_OK) complain("%s: %s", path, error.text);
    return fit;
}

/* A file of `flare fit`, from malloc. lflare_file_read would do for all but the lenses of a thousand ghosts. What is no fit of the lens
   ends the program, or if it was not asked for by name is said and left. */
static void *read_fit(const char *path, int named, const lflare_lens *lens, size_t *size)
{
    const size_t limit = (size_t)256 << 20;
    FILE *file = fopen(path, "rb");
    size_t room = 1 << 16;
    char *fit = NULL;
    lflare_error error;
    if (file == NULL) complain("%s: %s", path, strerror(errno));
    *size = 0;
    do {
        room *= 2;
        if (room > limit) complain("%s: the file is larger than any fit", path);
        fit = (char *)realloc(fit, room);
        if (fit == NULL) complain("out of memory");
        errno = 0;
        *size += fread(fit + *size, 1, room - *size, file);
    } while (*size == room);
    if (ferror(file)) complain("%s: %s", path, strerror(errno));
    fclose(file);
    if (lflare_aberration_check(lens, fit, *size, &error) == LFLARE_OK) return fit;
    if (named) complain("%s: %s", path, error.text);
    fprintf(stderr, "flare: %s is not used: %s\n", path, error.text);
    free(fit);
    return NULL;
}

static int command_fit(int argc, char **argv)
{
    static lflare_lens lens;
    options o = parse(argc, argv, " -o " PATH_OPTIONS, 1);
    double spent;
    size_t size;
    output *out;
    void *fit;
    if (o.out == NULL) complain("flare fit: say where the fit goes, with -o FILE");
    if (ends_with(o.out, ".lens")) complain("%s: a lens would be lost; end the fit's name in .fit, say", o.out);
    read_lens(o.operands[0], &o.paths, &lens);
    out = output_open(o.out); /* first, so that the work has a place to go */
    fit = fit_lens(o.operands[0], &lens, &size, &spent);
    fwrite(fit, 1, size, out->file);
    output_close(out);
    free(fit);
    /* what goes down a pipe is not followed by words */
    fprintf(out->part[0] != 0 ? stdout : stderr, "%s: %d ghosts, %.0f bytes, %.2f s\n", o.out, (int)lens.ghost_count, (double)size, spent);
    return finish();
}

/* The fit that lies beside a lens, NULL for none. */
static void *fit_beside(const char *path, const lflare_lens *lens, size_t *size)
{
    size_t length = strlen(path);
    char *name = (char *)malloc(length + 5);
    void *fit = NULL;
    FILE *file;
    if (name == NULL) complain("out of memory");
    strcpy(name, path);
    strcpy(name + (ends_with(path, ".lens") ? length - 5 : length), ".fit");
    file = fopen(name, "rb");
    if (file != NULL) {
        fclose(file);
        fit = read_fit(name, 0, lens, size);
    }
    free(name);
    return fit;
}

/* The fit that the options call for, NULL for none. */
static void *fit_for_render(const options *o, const lflare_lens *lens, size_t *size)
{
    double spent;
    void *fit;
    if (o->fit != NULL) return read_fit(o->fit, 1, lens, size);
    if (o->reference || o->model == LFLARE_MODEL_PARAXIAL || o->model == LFLARE_MODEL_TRACED) return NULL;
    fit = fit_beside(o->operands[0], lens, size);
    if (fit != NULL || o->model != LFLARE_MODEL_POLYNOMIAL) return fit;
    fit = fit_lens(o->operands[0], lens, size, &spent);
    if (isatty(2)) fprintf(stderr, "flare: %d ghosts fitted in %.2f s; 'flare fit' saves them for --fit\n", (int)lens->ghost_count, spent);
    return fit;
}

/* ---- irises ---- */

#define IRIS_OPTIONS "--softness --mask --dust --scratches --grating --seed "

static picture read_picture(const char *path);

/* What the options put into the iris; its image is the caller's to free. */
static float *mask_of(const options *o, lflare_mask_desc *desc)
{
    lflare_error error;
    picture p = {0};
    size_t i;
    memset(desc, 0, sizeof *desc);
    if (o->mask != NULL) {
        p = read_picture(o->mask);
        for (i = 0; i < (size_t)p.width * (size_t)p.height; i++) p.rgb[i] = (p.rgb[3 * i] + p.rgb[3 * i + 1] + p.rgb[3 * i + 2]) / 3;
        desc->pixels = p.rgb;
        desc->width = p.width;
        desc->height = p.height;
    }
    desc->dust_count = o->dust;
    desc->scratch_count = o->scratches;
    desc->scratch_spread = 1.6f;
    desc->grating_lines = (float)o->grating;
    desc->grating_depth = 0.5f;
    desc->seed = (uint32_t)o->seed;
    if (lflare_mask_check(desc, &error) != LFLARE_OK) complain("%s: %s", o->mask != NULL ? o->mask : "the iris", error.text);
    return p.rgb;
}

static void write_picture(const char *path, const lflare_image *image);

static void check_picture_name(const options *o, const char *command)
{
    if (o->out == NULL) complain("flare %s: say where the picture goes, with -o OUT.png or -o OUT.pfm", command);
    if (!ends_with(o->out, ".png") && !ends_with(o->out, ".pfm")) complain("%s: a name ending in .png or .pfm was expected", o->out);
}

static int command_starburst(int argc, char **argv)
{
    static lflare_lens lens;
    options o = parse(argc, argv, " -o --size --width --fnumber --blades --rotation --curvature --radius --exposure " IRIS_OPTIONS, 1);
    lflare_mask_desc desc;
    lflare_starburst starburst;
    lflare_starburst_job job;
    lflare_iris iris;
    lflare_image image = {0};
    float *tables = (float *)allocate(LFLARE_STARBURST_FLOATS, sizeof(float)), *pixels = NULL, unit, pixel, blur, gain = 1, rgb[3];
    void *work = allocate(lflare_starburst_bytes(1024), 1);
    uint8_t *mask = (uint8_t *)allocate(LFLARE_MASK_BYTES, 1);
    double fnumber;
    int x, y, k;
    check_picture_name(&o, "starburst");
    read_lens(o.operands[0], &o.paths, &lens);
    pixels = mask_of(&o, &desc);
    lflare_iris_make(&lens, o.fnumber, o.blades >= 0 ? o.blades : 6, o.rotation * DEGREE, o.curvature, &iris, &fnumber);
    iris.softness = (float)o.softness;
    if (o.mask != NULL || o.dust > 0 || o.scratches > 0 || o.grating > 0) {
        lflare_mask_rows(&desc, mask, 0, LFLARE_MASK_SIZE);
        if (lflare_iris_set_mask(&iris, mask) != LFLARE_OK) complain("%s: the mask and the blades together let nothing pass", o.operands[0]);
    }
    lflare_starburst_begin(&iris, 1024, tables, work, &starburst, &job);
    lflare_starburst_step(&job, INT32_MAX);
    unit = (float)(550e-6 * fnumber);
    image.width = image.height = o.width < 1280 || o.height != 720 ? o.width : 512;
    image.pixels = (float *)allocate((size_t)image.width * (size_t)image.height, 4 * sizeof(float));
    pixel = (float)(o.sensor_width > 0 ? o.sensor_width : 200 * (double)unit) / (float)image.width;
    blur = (float)hypot(0.564 * (double)pixel, lens.efl * o.radius * 1e-3);
    if (ends_with(o.out, ".png")) { /* as bright as half of white an eighth of the way out */
        lflare_starburst_at(&starburst, 0.0625f * (float)image.width * pixel / unit, 0, blur / unit, rgb);
        gain = exp2f((float)o.exposure) * 0.5f * unit * unit / (rgb[1] > 0 ? rgb[1] : 1);
    }
    for (y = 0; y < image.height; y++)
        for (x = 0; x < image.width; x++) {
            float *out = image.pixels + 4 * ((size_t)y * (size_t)image.width + (size_t)x);
            lflare_starburst_at(&starburst, ((float)x + 0.5f - 0.5f * (float)image.width) * pixel / unit, (0.5f * (float)image.height - (float)y - 0.5f) * pixel / unit, blur / unit, out);
            for (k = 0; k < 3; k++) out[k] *= gain / (unit * unit);
        }
    write_picture(o.out, &image);
    free(image.pixels);
    free(pixels);
    free(mask);
    free(work);
    free(tables);
    return 0;
}

/* ---- render ---- */

static void check_render_options(const options *o)
{
    check_picture_name(o, "render");
    if (!o->reference && o->cells > 0) complain("--cells belongs to --model reference");
    if (!o->reference && o->wavelengths > LFLARE_MAX_WAVELENGTHS) complain("--wavelengths: %d is too many; at most %d, or 256 with --model reference", o->wavelengths, LFLARE_MAX_WAVELENGTHS);
    if (!o->reference && o->wavelengths > 3 && o->model == LFLARE_MODEL_PARAXIAL) complain("--wavelengths belongs to --model polynomial, traced or reference, not to paraxial");
    if (o->reference && o->gl) complain("--model reference has no --backend gl");
    if (o->fit != NULL && (o->reference || o->model == LFLARE_MODEL_PARAXIAL || o->model == LFLARE_MODEL_TRACED))
        complain("--fit belongs to --model polynomial, not to --model %s", o->reference ? "reference" : o->model == LFLARE_MODEL_TRACED ? "traced" : "paraxial");
}

/* The image to the file, as its name says. */
static void write_picture(const char *path, const lflare_image *image)
{
    size_t pixels = (size_t)image->width * (size_t)image->height, i;
    picture p;
    if (ends_with(path, ".png")) {
        uint8_t *bytes = (uint8_t *)allocate(pixels, 3);
        for (i = 0; i < 4 * pixels; i++) image->pixels[i] = 1 - expf(-image->pixels[i]); /* rolls highlights off */
        lflare_to_rgb8(image->pixels, pixels, 1, 1, bytes);
        write_png(path, image->width, image->height, bytes);
        free(bytes);
        return;
    }
    p.width = image->width;
    p.height = image->height;
    p.rgb = (float *)allocate(pixels, 3 * sizeof(float));
    for (i = 0; i < pixels; i++) memcpy(p.rgb + 3 * i, image->pixels + 4 * i, 3 * sizeof(float));
    write_pfm(path, &p);
    free(p.rgb);
}

static int command_render(int argc, char **argv)
{
    static lflare_lens lens;
    options o = parse(argc, argv,
                      " -o --size --angle --fov --fnumber --blades --rotation --curvature --radius --model --backend --ghosts-only --exposure "
                      "--wavelengths --cells --fit " IRIS_OPTIONS PATH_OPTIONS "--streak --squeeze --ringing --budget --vertices --pixels --imperfection ", 1);
    lflare_desc desc = {0};
    lflare_view view = {0};
    lflare_light light = {0};
    lflare_image image = {0};
    lflare_error error;
    lflare *flare;
    float *mask;
    void *fit;
    int png, k;
    check_render_options(&o);
    png = ends_with(o.out, ".png");
    read_lens(o.operands[0], &o.paths, &lens);
    desc.prescription = &lens.prescription;
    desc.paths = o.paths;
    desc.fit = fit = fit_for_render(&o, &lens, &desc.fit_size);
    desc.settings.model = o.model;
    desc.settings.wavelengths = o.reference ? 0 : o.wavelengths;
    desc.settings.fnumber = o.fnumber;
    desc.settings.blades = o.blades >= 0 ? o.blades : o.ghosts_only ? 0 : 6;
    desc.settings.no_starburst = o.ghosts_only || o.reference;
    desc.settings.no_ringing = o.ringing == 0 ? o.ghosts_only : o.ringing == 1;
    if (o.reference && (o.mask != NULL || o.dust + o.scratches + o.grating > 0 || o.softness > 0 || o.streak > 0))
        complain("--model reference draws ghosts of sharp blades alone");
    mask = mask_of(&o, &desc.settings.mask);
    if (o.reference && (o.budget > 0 || o.vertices > 0 || o.pixels > 0 || o.imperfection > 0))
        complain("--model reference draws every ghost of a perfect lens");
    desc.settings.ghost_budget = o.budget;
    desc.settings.vertex_budget = o.vertices;
    desc.settings.pixel_budget = o.pixels;
    desc.settings.imperfection = (float)o.imperfection;
    desc.settings.imperfection_seed = (uint32_t)o.seed;
    desc.settings.iris_softness = (float)o.softness;
    desc.settings.streak.share = (float)o.streak;
    desc.settings.blade_rotation = (float)(o.rotation * DEGREE);
    desc.settings.blade_curvature = (float)o.curvature;
    desc.settings.raw = !png;
    desc.settings.exposure_ev = png ? (float)o.exposure : 0;
    if (lflare_create(&desc, &flare, &error) != LFLARE_OK) complain("%s: %s", o.operands[0], error.text);
    view.width = o.width;
    view.height = o.height;
    view.squeeze = (float)o.squeeze;
    view.fov_y = (float)(o.fov * DEGREE);
    view.fit = o.fov > 0 ? LFLARE_FIT_PHYSICAL : LFLARE_FIT_WIDTH;
    light.direction[0] = (float)tan(o.ax * DEGREE);
    light.direction[1] = (float)tan(o.ay * DEGREE);
    light.direction[2] = -1;
    for (k = 0; k < 3; k++) light.color[k] = 1;
    light.angular_radius = (float)(o.radius * 1e-3);
    image.width = o.width;
    image.height = o.height;
    image.pixels = (float *)allocate((size_t)o.width * (size_t)o.height, 4 * sizeof(float));
    if (lflare_frame(flare, &view, &light, 1) != LFLARE_OK) complain("%s: the frame cannot be drawn", o.operands[0]);
    if (o.reference) render_reference(flare, &o, &image);
    else if (o.gl) render_gl(flare, &image);
    else if (lflare_render(flare, &image) != LFLARE_OK) complain("%s: the frame cannot be drawn", o.operands[0]);
    write_picture(o.out, &image);
    free(image.pixels);
    lflare_destroy(flare);
    free(mask);
    free(fit);
    return 0;
}

/* ---- diagrams ---- */

static int command_diagram(int argc, char **argv)
{
    static lflare_lens lens;
    static lflare_path path;
    options o = parse(argc, argv, " -o --ghost --rays --angle --across-stop ", 1);
    double x = tan(o.ax * DEGREE), y = tan(o.ay * DEGREE);
    diagram_desc desc;
    lflare_pair pair;
    output *out;
    if (o.out == NULL) complain("flare diagram: say where the drawing goes, with -o OUT.svg");
    if (!ends_with(o.out, ".svg")) complain("%s: a name ending in .svg was expected", o.out);
    read_lens(o.operands[0], &o.paths, &lens);
    make_path(&lens, &o, &path); /* refuses what is no ghost */
    pair = counted_from_0(o.ghost);
    desc.lens = &lens;
    desc.ghost = o.ghost.first > 0 ? &pair : NULL;
    desc.slope = (y < 0 || (y == 0 && x < 0) ? 1 : -1) * hypot(x, y);
    desc.rays = o.rays;
    out = output_open(o.out);
    diagram_write(out->file, &desc);
    output_close(out);
    return 0;
}

/* ---- compare ---- */

static picture read_pfm(const char *path, FILE *file)
{
    picture p;
    float scale = 0;
    char kind = 0;
    static const uint16_t one = 1;
    int y, little = *(const uint8_t *)&one == 1;
    size_t channels, i, count;
    if (fscanf(file, "P%c %d %d %f", &kind, &p.width, &p.height, &scale) != 4 || (kind != 'F' && kind != 'f') || scale == 0 || fgetc(file) == EOF)
        complain("%s: not a PFM picture", path);
    if (p.width < 1 || p.height < 1 || p.width > 65536 || p.height > 65536) complain("%s: %d x %d pixels", path, p.width, p.height);
    channels = kind == 'F' ? 3 : 1;
    count = (size_t)p.width * (size_t)p.height;
    p.rgb = (float *)allocate(count, 3 * sizeof(float));
    for (y = p.height - 1; y >= 0; y--) {
        float *row = p.rgb + (size_t)y * (size_t)p.width * 3;
        if (fread(row, sizeof(float) * channels, (size_t)p.width, file) != (size_t)p.width) complain("%s: the file ends before the picture does", path);
        for (i = (size_t)p.width; channels == 1 && i-- > 0;) row[3 * i] = row[3 * i + 1] = row[3 * i + 2] = row[i];
    }
    for (i = 0; (scale < 0) != little && i < 3 * count; i++) {
        uint8_t b[4], r[4];
        memcpy(b, &p.rgb[i], 4);
        r[0] = b[3]; r[1] = b[2]; r[2] = b[1]; r[3] = b[0];
        memcpy(&p.rgb[i], r, 4);
    }
    for (i = 0; i < 3 * count; i++)
        if (p.rgb[i] - p.rgb[i] != 0) complain("%s: a pixel is not a finite number", path);
    return p;
}

static picture read_png(const char *path, FILE *file)
{
#ifdef FLARE_HAVE_PNG
    picture p;
    png_image image;
    uint8_t *bytes;
    size_t i, count;
    memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_stdio(&image, file)) complain("%s: %s", path, image.message);
    image.format = PNG_FORMAT_RGB;
    p.width = (int)image.width;
    p.height = (int)image.height;
    count = 3 * (size_t)p.width * (size_t)p.height;
    bytes = (uint8_t *)allocate(count, 1);
    p.rgb = (float *)allocate(count, sizeof(float));
    if (!png_image_finish_read(&image, NULL, bytes, 0, NULL)) complain("%s: %s", path, image.message);
    for (i = 0; i < count; i++) {
        float v = (float)bytes[i] / 255;
        p.rgb[i] = v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f);
    }
    free(bytes);
    return p;
#else
    (void)file;
    complain("%s: this flare was built without libpng; compare .pfm pictures, or install libpng-dev and run make again", path);
    exit(2);
#endif
}

static picture read_picture(const char *path)
{
    FILE *file = fopen(path, "rb");
    picture p;
    if (file == NULL) complain("%s: %s", path, strerror(errno));
    p = ends_with(path, ".png") ? read_png(path, file) : read_pfm(path, file);
    fclose(file);
    return p;
}

/* Blurs with the usual 11-tap Gaussian of sigma 1.5, edges repeated. */
static void blur(float *image, float *scratch, int width, int height)
{
    float tap[11], sum = 0;
    int i, x, y, pass;
    for (i = 0; i < 11; i++) sum += tap[i] = expf(-(float)((i - 5) * (i - 5)) / 4.5f);
    for (pass = 0; pass < 2; pass++) {
        const float *from = pass ? scratch : image;
        float *to = pass ? image : scratch;
        for (y = 0; y < height; y++)
            for (x = 0; x < width; x++) {
                float v = 0;
                for (i = -5; i <= 5; i++) {
                    int sx = pass ? x : x + i, sy = pass ? y + i : y;
                    sx = sx < 0 ? 0 : sx >= width ? width - 1 : sx;
                    sy = sy < 0 ? 0 : sy >= height ? height - 1 : sy;
                    v += tap[i + 5] * from[(size_t)sy * (size_t)width + (size_t)sx];
                }
                to[(size_t)y * (size_t)width + (size_t)x] = v / sum;
            }
    }
}

/* Mean structural similarity of the tone-mapped luminance (Wang et al. 2004). */
static double ssim_of(const picture *a, const picture *b, float white)
{
    size_t count = (size_t)a->width * (size_t)a->height, i;
    float *plane = (float *)allocate(count * 6, sizeof(float)), *m[5], *scratch = plane + 5 * count;
    double sum = 0;
    int k;
    for (k = 0; k < 5; k++) m[k] = plane + (size_t)k * count;
    for (i = 0; i < count; i++) {
        const float *p = a->rgb + 3 * i, *q = b->rgb + 3 * i;
        float x = 0.2126f * tone(p[0], white) + 0.7152f * tone(p[1], white) + 0.0722f * tone(p[2], white);
        float y = 0.2126f * tone(q[0], white) + 0.7152f * tone(q[1], white) + 0.0722f * tone(q[2], white);
        m[0][i] = x; m[1][i] = y; m[2][i] = x * x; m[3][i] = y * y; m[4][i] = x * y;
    }
    for (k = 0; k < 5; k++) blur(m[k], scratch, a->width, a->height);
    for (i = 0; i < count; i++) {
        double x = (double)m[0][i], y = (double)m[1][i], c1 = 1e-4, c2 = 9e-4;
        double vx = (double)m[2][i] - x * x, vy = (double)m[3][i] - y * y, cov = (double)m[4][i] - x * y;
        sum += (2 * x * y + c1) * (2 * cov + c2) / ((x * x + y * y + c1) * (vx + vy + c2));
    }
    free(plane);
    return sum / (double)count;
}

static int command_compare(int argc, char **argv)
{
    options o = parse(argc, argv, " --json ", 2);
    picture a = read_picture(o.operands[0]), b = read_picture(o.operands[1]);
    comparison c;
    double ssim;
    if (a.width != b.width || a.height != b.height)
        complain("%s is %d x %d pixels, %s is %d x %d: only pictures of one size compare", o.operands[0], a.width, a.height, o.operands[1], b.width, b.height);
    c = compare_pictures(&a, &b);
    ssim = ssim_of(&a, &b, c.white);
    if (o.json) {
        printf("{\"psnr_db\": ");
        print_number(c.psnr);
        printf(", \"psnr_linear_db\": ");
        print_number(c.psnr_linear);
        printf(", \"ssim\": ");
        print_number(ssim);
        printf(", \"largest_error\": ");
        print_number(c.largest);
        printf(", \"white\": ");
        print_number((double)c.white);
        printf(", \"lit_pixels\": %.0f}\n", (double)c.lit);
    } else {
        printf("PSNR           %.2f dB (lit pixels, white %.4g, gamma 2.2)\nPSNR linear    %.2f dB\nSSIM           %.5f\nlargest error  %.4g\n", c.psnr,
               (double)c.white, c.psnr_linear, ssim, c.largest);
    }
    free(a.rgb);
    free(b.rgb);
    return finish();
}

/* ---- coating ---- */

static int32_t parse_layers(const char *text, lflare_layer *out, int32_t room)
{
    int32_t count = 0;
    while (*text != 0) {
        char one[64];
        size_t n = strcspn(text, ",");
        if (n >= sizeof one) complain("--layers: 'n:nm,n:nm,...' was expected, not '%s'", text);
        memcpy(one, text, n);
        one[n] = 0;
        if (count == room) complain("--layers: more than %d layers", (int)room);
        two_numbers("--layers", one, ':', 0.01, 1e5, &out[count].n, &out[count].thickness_nm);
        if (out[count].n < 1 || out[count].n > 10) complain("--layers: an index is between 1 and 10, not %g", out[count].n);
        count++;
        text += n + (text[n] == ',');
    }
    return count;
}

static int command_coating(int argc, char **argv)
{
    options o = parse(argc, argv, " --lambda0 --layers --angle --csv ", 2);
    double n1 = number("N1", o.operands[0], 1, 5), n2 = number("N2", o.operands[1], 1, 5), nm, s;
    lflare_layer layers[256];
    int32_t count = 0;
    if (o.lambda0 > 0 && o.layers != NULL) complain("flare coating: --lambda0 or --layers, not both");
    if (o.lambda0 > 0) {
        layers[0].n = fmax(sqrt(n1 * n2), 1.38);
        layers[0].thickness_nm = o.lambda0 / (4 * layers[0].n);
        count = 1;
    } else if (o.layers != NULL) {
        count = parse_layers(o.layers, layers, 256);
    }
    s = n1 * sin(o.angle * DEGREE);
    if (o.csv) printf("lambda_nm,R\n");
    else printf("reflectance from %g to %g at %g degrees, %d layer%s\n", n1, n2, o.angle, (int)count, count == 1 ? "" : "s");
    for (nm = 380; nm <= 780; nm += 10) {
        double r = lflare_film_reflectance(n1, n2, layers, count, nm, s);
        if (o.csv) {
            printf("%g,", nm);
            print_number(r);
            putchar('\n');
        } else {
            int bar = (int)(r * 1000 + 0.5);
            printf("%4g nm %8.4f %% ", nm, 100 * r);
            for (; bar > 0; bar--) putchar(bar > 60 ? '+' : '#'), bar = bar > 61 ? 61 : bar;
            putchar('\n');
        }
    }
    return finish();
}

#include "edit.h"
#include "optimize.h"
#include "coatings.h"

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        int (*run)(int, char **);
    } commands[] = {{"info", command_info}, {"ghosts", command_ghosts},   {"trace", command_trace},     {"render", command_render},
                    {"starburst", command_starburst}, {"fit", command_fit},   {"diagram", command_diagram}, {"compare", command_compare}, {"coating", command_coating},
                    {"convert", command_convert}, {"check", command_check},   {"glass", command_glass},
                    {"edit", command_edit}, {"colour-map", command_colour_map}, {"target", command_target}, {"optimize", command_optimize},
                    {"optimize-colour", command_optimize_colour}};
    size_t i;
    int k;
    for (k = 1; k < argc; k++)
        if (strcmp(argv[k], "--help") == 0 || (k == 1 && strcmp(argv[k], "help") == 0)) {
            print_help(stdout);
            return finish();
        }
    if (argc > 1 && strcmp(argv[1], "--version") == 0) {
        printf("flare %d.%d.%d\n", LFLARE_VERSION / 10000, LFLARE_VERSION / 100 % 100, LFLARE_VERSION % 100);
        return finish();
    }
    if (argc < 2) {
        print_help(stderr);
        return 2;
    }
    for (i = 0; i < sizeof commands / sizeof commands[0]; i++)
        if (strcmp(argv[1], commands[i].name) == 0) return commands[i].run(argc, argv);
    complain("unknown command '%s'; see flare --help", argv[1]);
    return 2;
}
