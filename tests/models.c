/* make models: how near the paraxial, the polynomial and the traced ghosts come to exact rays (examples/reference.h), picture by picture:
   PSNR and SSIM as `flare compare` measures them. A point of light, three wavelengths, raw irradiance, ghosts only.
   References take 2 s to 3 min each on two cores and are kept in build/reference, as PFM, under names that hold all they depend on but
   the code: delete them when the tracing or reference.h changes. */
#define _POSIX_C_SOURCE 200809L
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include "examples/reference.h"
#include <errno.h>
#include <sys/stat.h>
#include <time.h>

#define DEGREE (3.14159265358979323846 / 180)
#define FOLDER "build/reference"

enum { CELLS = 96, SWEEP_CELLS = 24, SWEEP = 200, MAX_ANGLES = 16, WORST = 6, PARAXIAL = 0, POLYNOMIAL = 1, TRACED = 2, MODELS = 3 };

static const lflare_model models[MODELS] = {LFLARE_MODEL_PARAXIAL, LFLARE_MODEL_POLYNOMIAL, LFLARE_MODEL_TRACED};
static const char *const model_names[MODELS] = {"paraxial", "polynomial", "traced"};

static const char help[] =
    "models [--only SUBSTRING] [--size WxH] [--angles A,B,...] [--fnumber N] [--worst [--traced]] [--sweep]\n"
    "  the paraxial, the polynomial and the traced model against exact rays; run it from the root\n"
    "  --only     the lenses whose file names hold it\n"
    "  --size     of the pictures (default: 1280x720)\n"
    "  --angles   of the light from the axis, degrees (default: 5.45,13.4,20)\n"
    "  --fnumber  this one alone, 0 = wide open (default: 8 and wide open)\n"
    "  --worst    under each picture the six ghosts that do it most harm: the PSNR of the reference with this polynomial ghost in\n"
    "             place of its own, and of the ghost's picture alone, its light over the reference's, and the same for the paraxial\n"
    "  --traced   with --worst: of the traced ghosts, not of the polynomial ones; slow\n"
    "  --sweep    instead, a light that moves through 200 places: how much of the picture changes from one to the next, against how\n"
    "             much of exact rays' does; nothing that jumps or sparkles stays below 1.5\n";

static void complain(const char *format, ...)
{
    va_list list;
    fputs("models: ", stderr);
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

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- pictures ---- */

typedef struct picture {
    int width, height;
    float *rgb; /* rows from the top */
} picture;

static picture picture_make(int width, int height)
{
    picture p;
    p.width = width;
    p.height = height;
    p.rgb = (float *)allocate((size_t)width * (size_t)height, 3 * sizeof(float));
    return p;
}

static size_t pixels_of(const picture *p) { return (size_t)p->width * (size_t)p->height; }

static float brightest(const float *rgb) { return fmaxf(rgb[0], fmaxf(rgb[1], rgb[2])); }

static double light_of(const picture *p)
{
    size_t count = 3 * pixels_of(p), i;
    double sum = 0;
    for (i = 0; i < count; i++) sum += (double)p->rgb[i];
    return sum;
}

static int by_brightness(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* 99.8th percentile of what is lit; 0 if nothing is. */
static float white_of(const picture *p)
{
    size_t count = pixels_of(p), i, n = 0;
    float *lit = (float *)allocate(count, sizeof(float)), white = 0;
    for (i = 0; i < count; i++)
        if (brightest(p->rgb + 3 * i) > 0) lit[n++] = brightest(p->rgb + 3 * i);
    if (n > 0) {
        qsort(lit, n, sizeof(float), by_brightness);
        white = lit[(size_t)((double)(n - 1) * 0.998)];
    }
    free(lit);
    return white;
}

static float tone(float v, float white) { return powf(fminf(fmaxf(v / white, 0), 1), 1 / 2.2f); }

static double decibels(double squares, double count) { return squares > 0 && count > 0 ? -10 * log10(squares / count) : HUGE_VAL; }

/* ---- how alike pictures are: the figures of `flare compare` ---- */

typedef struct likeness {
    double psnr, linear, ssim;
} likeness;

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

/* Mean structural similarity of two luminances (Wang et al. 2004). Planes of m: 0 and 1 the luminances, then room for four. */
static double ssim_of(float *m[6], int width, int height)
{
    size_t count = (size_t)width * (size_t)height, i;
    double sum = 0;
    int k;
    for (i = 0; i < count; i++) {
        float x = m[0][i], y = m[1][i];
        m[2][i] = x * x, m[3][i] = y * y, m[4][i] = x * y;
    }
    for (k = 0; k < 5; k++) blur(m[k], m[5], width, height);
    for (i = 0; i < count; i++) {
        double x = (double)m[0][i], y = (double)m[1][i], c1 = 1e-4, c2 = 9e-4;
        double vx = (double)m[2][i] - x * x, vy = (double)m[3][i] - y * y, cov = (double)m[4][i] - x * y;
        sum += (2 * x * y + c1) * (2 * cov + c2) / ((x * x + y * y + c1) * (vx + vy + c2));
    }
    return sum / (double)count;
}

/* Picture b against picture a: PSNR over the pixels that either lights, SSIM over all. */
static likeness compare(const picture *a, const picture *b)
{
    static const float luma[3] = {0.2126f, 0.7152f, 0.0722f};
    size_t count = pixels_of(a), i;
    float white = white_of(a), *planes = (float *)allocate(count * 6, sizeof(float)), *m[6];
    double toned = 0, linear = 0, lit = 0;
    likeness result;
    int k;
    for (k = 0; k < 6; k++) m[k] = planes + (size_t)k * count;
    if (!(white > 0)) white = 1;
    for (i = 0; i < count; i++) {
        const float *p = a->rgb + 3 * i, *q = b->rgb + 3 * i;
        int seen = fmaxf(brightest(p), brightest(q)) > 1e-4f * white;
        lit += 3 * seen;
        for (k = 0; k < 3; k++) {
            float s = tone(p[k], white), t = tone(q[k], white);
            double d = (double)(s - t), l = (double)(fminf(fmaxf(p[k] / white, 0), 1) - fminf(fmaxf(q[k] / white, 0), 1));
            m[0][i] += luma[k] * s;
            m[1][i] += luma[k] * t;
            if (seen) toned += d * d, linear += l * l;
        }
    }
    result.psnr = decibels(toned, lit);
    result.linear = decibels(linear, lit);
    result.ssim = ssim_of(m, a->width, a->height);
    free(planes);
    return result;
}

/* PSNR, against the whole reference, of the reference with one ghost changed from `from` to `to`. */
static double harm_of(const picture *whole, float white, const picture *from, const picture *to)
{
    size_t count = pixels_of(whole), i;
    double sum = 0, lit = 0;
    int k;
    for (i = 0; i < count; i++) {
        const float *r = whole->rgb + 3 * i, *f = from->rgb + 3 * i, *t = to->rgb + 3 * i;
        float changed[3];
        for (k = 0; k < 3; k++) changed[k] = r[k] - f[k] + t[k];
        if (fmaxf(brightest(r), brightest(changed)) <= 1e-4f * white) continue;
        lit += 3;
        if (brightest(f) <= 0 && brightest(t) <= 0) continue;
        for (k = 0; k < 3; k++) {
            double d = (double)(tone(r[k], white) - tone(changed[k], white));
            sum += d * d;
        }
    }
    return decibels(sum, lit);
}

/* ---- lenses ---- */

typedef struct subject {
    const char *name;
    unsigned long long hash; /* of the file */
    lflare_lens lens;
    void *fit;
    lflare *flare;
} subject;

typedef struct scene {
    double angle; /* degrees */
    int diagonal;
    double fnumber; /* 0 = wide open */
    int blades, width, height;
} scene;

static const double ways[2][2] = {{1, 0}, {0.8, 0.6}}; /* towards the light, in the picture */
static const char *const way_names[2] = {"axis", "diagonal"};

/* FNV-1a. */
static unsigned long long hash_of(const char *bytes, size_t size)
{
    unsigned long long hash = 0xcbf29ce484222325ull;
    size_t i;
    for (i = 0; i < size; i++) hash = (hash ^ (unsigned char)bytes[i]) * 0x100000001b3ull;
    return hash;
}

static void read_lens(subject *s)
{
    static lflare_prescription prescription;
    lflare_error error;
    char path[200], *text;
    size_t size;
    lflare_result result;
    sprintf(path, "lenses/%.150s.lens", s->name);
    result = lflare_file_read(path, NULL, NULL, &text, &size, &error);
    if (result == LFLARE_OK) {
        s->hash = hash_of(text, size);
        result = lflare_text_read(text, size, &prescription, &error);
        free(text);
    }
    if (result == LFLARE_OK) result = lflare_lens_derive(&prescription, &s->lens, &error);
    if (result != LFLARE_OK) complain("%s: %s", path, error.text);
}

/* Seconds that lflare_create takes; the object is left in s->flare. */
static double create(subject *s, const void *fit, size_t fit_size)
{
    lflare_desc desc;
    lflare_error error;
    double began;
    memset(&desc, 0, sizeof desc);
    desc.prescription = &s->lens.prescription;
    desc.settings.model = fit != NULL ? LFLARE_MODEL_POLYNOMIAL : LFLARE_MODEL_PARAXIAL;
    desc.settings.no_starburst = desc.settings.no_ringing = 1; /* as exact rays have it */
    desc.fit = fit;
    desc.fit_size = fit_size;
    began = now();
    if (lflare_create(&desc, &s->flare, &error) != LFLARE_OK) complain("%s: %s", s->name, error.text);
    return now() - began;
}

static void open_subject(subject *s)
{
    lflare_error error;
    size_t size = 0;
    double fitted, paraxial, polynomial, began;
    read_lens(s);
    began = now();
    if (lflare_aberration_fit(&s->lens, NULL, &s->fit, &size, &error) != LFLARE_OK) complain("%s: %s", s->name, error.text);
    fitted = now() - began;
    paraxial = create(s, NULL, 0);
    lflare_destroy(s->flare);
    polynomial = create(s, s->fit, size);
    printf("%s: %s\n%d ghosts, f/%.3g; lflare_aberration_fit %.2f s, %.1f KB; lflare_create %.1f ms with it, %.1f ms without\n", s->name,
           s->lens.prescription.name, (int)s->lens.ghost_count, s->lens.fnumber, fitted, (double)size / 1024, 1000 * polynomial, 1000 * paraxial);
}

static void close_subject(subject *s)
{
    lflare_destroy(s->flare);
    free(s->fit);
}

static lflare_pair *ghosts_of(const lflare_lens *lens)
{
    int32_t count = lens->ghost_count;
    lflare_pair *pairs = (lflare_pair *)allocate((size_t)count, sizeof *pairs);
    lflare_ghost_list(lens, pairs, &count);
    return pairs;
}

/* ---- references ---- */

/* The part of a picture that is not black, x0 y0 x1 y1; one pixel at least. */
static void lit_box(const picture *p, int *box)
{
    int x, y;
    box[0] = p->width - 1, box[1] = p->height - 1, box[2] = box[3] = 0;
    for (y = 0; y < p->height; y++)
        for (x = 0; x < p->width; x++) {
            if (brightest(p->rgb + 3 * ((size_t)y * (size_t)p->width + (size_t)x)) <= 0) continue;
            if (x < box[0]) box[0] = x;
            if (x >= box[2]) box[2] = x + 1;
            if (y < box[1]) box[1] = y;
            if (y >= box[3]) box[3] = y + 1;
        }
    if (box[2] == 0) box[0] = box[1] = 0, box[2] = box[3] = 1;
}

/* A PFM of the box, and behind it where the box lies: other readers stop before that. It has its name only when it is whole. */
static void keep(const char *path, const picture *p, const int *box)
{
    static const uint16_t one = 1;
    char part[340];
    FILE *file;
    int y, bad;
    sprintf(part, "%.300s.%ld.part", path, (long)getpid());
    file = fopen(part, "wb");
    if (file == NULL) complain("%s: %s", part, strerror(errno));
    fprintf(file, "PF\n%d %d\n%s\n", box[2] - box[0], box[3] - box[1], *(const uint8_t *)&one ? "-1.0" : "1.0");
    for (y = box[3] - 1; y >= box[1]; y--)
        fwrite(p->rgb + 3 * ((size_t)y * (size_t)p->width + (size_t)box[0]), sizeof(float) * 3, (size_t)(box[2] - box[0]), file);
    fprintf(file, "\n%d %d\n", box[0], box[1]);
    bad = ferror(file);
    if (fclose(file) != 0 || bad || rename(part, path) != 0) {
        remove(part);
        complain("%s cannot be written", path);
    }
}

/* 1 if the picture was kept; p is black where the kept part does not reach. */
static int find_kept(const char *path, picture *p)
{
    FILE *file = fopen(path, "rb");
    int width = 0, height = 0, x0 = -1, y0 = -1, y, found;
    long start;
    double scale;
    if (file == NULL) return 0;
    found = fscanf(file, "PF %d %d %lf", &width, &height, &scale) == 3 && fgetc(file) == '\n' && width > 0 && width <= p->width && height > 0 &&
            height <= p->height;
    start = ftell(file);
    found = found && fseek(file, 12L * width * height, SEEK_CUR) == 0 && fscanf(file, "%d %d", &x0, &y0) == 2 && x0 >= 0 && y0 >= 0 &&
            x0 + width <= p->width && y0 + height <= p->height && fseek(file, start, SEEK_SET) == 0;
    for (y = y0 + height - 1; found && y >= y0; y--)
        found = fread(p->rgb + 3 * ((size_t)y * (size_t)p->width + (size_t)x0), sizeof(float) * 3, (size_t)width, file) == (size_t)width;
    fclose(file);
    return found;
}

static void render_reference(const subject *s, const scene *c, const lflare_pair *only, int cells, picture *p)
{
    static const double nm[3] = {650, 510, 475};
    static reference_desc d;
    lflare_iris iris;
    int k;
    if (lflare_iris_make(&s->lens, c->fnumber, c->blades, 0, 0, &iris, NULL) != LFLARE_OK) complain("%s: no iris of f/%g", s->name, c->fnumber);
    memset(&d, 0, sizeof d);
    d.lens = &s->lens;
    d.iris = &iris;
    for (k = 0; k < 2; k++) d.slope[k] = -tan(c->angle * DEGREE) * ways[c->diagonal][k];
    d.half[0] = 0.5 * s->lens.sensor_width;
    d.half[1] = d.half[0] * c->height / c->width;
    d.width = c->width;
    d.height = c->height;
    d.wavelengths = 3;
    for (k = 0; k < 3; k++) d.nm[k] = nm[k], d.rgb[k][k] = 1;
    d.cells = cells;
    d.only = only;
    if (reference_render(&d, p->rgb) != 1) complain("out of memory");
}

/* The picture of exact rays, of all ghosts or of one; of one only the lit part is kept. */
static picture reference_of(const subject *s, const scene *c, const lflare_pair *only)
{
    picture p = picture_make(c->width, c->height);
    char path[300], ghost[32] = "";
    int box[4] = {0, 0, 0, 0};
    double began = now();
    if (only != NULL) sprintf(ghost, "-g%d,%d", (int)only->first + 1, (int)only->second + 1);
    sprintf(path, FOLDER "/%.100s-%016llx-f%g-b%d-%g-%s-%dx%d-c%d%s.pfm", s->name, s->hash, c->fnumber, c->blades, c->angle, way_names[c->diagonal],
            c->width, c->height, (int)CELLS, ghost);
    if (find_kept(path, &p)) return p;
    render_reference(s, c, only, CELLS, &p);
    box[2] = c->width;
    box[3] = c->height;
    if (only != NULL) lit_box(&p, box);
    keep(path, &p, box);
    if (only == NULL) fprintf(stderr, "%s in %.1f s\n", path, now() - began);
    return p;
}

/* ---- models ---- */

/* The scene as the frame that makes the library's slope the reference's. */
static void draw_frame(subject *s, const scene *c, float *rgba)
{
    lflare_view view;
    lflare_light light;
    lflare_image image;
    int k;
    memset(&view, 0, sizeof view);
    memset(&light, 0, sizeof light);
    memset(&image, 0, sizeof image);
    view.width = image.width = c->width;
    view.height = image.height = c->height;
    view.fit = LFLARE_FIT_WIDTH;
    for (k = 0; k < 2; k++) light.direction[k] = (float)(tan(c->angle * DEGREE) * ways[c->diagonal][k]);
    light.direction[2] = -1;
    for (k = 0; k < 3; k++) light.color[k] = 1;
    image.pixels = rgba;
    if (lflare_frame(s->flare, &view, &light, 1) != LFLARE_OK || lflare_render(s->flare, &image) != LFLARE_OK)
        complain("%s: the frame cannot be drawn", s->name);
}

/* A model's picture, of all ghosts or of one. */
static picture draw(subject *s, const scene *c, lflare_model model, const lflare_pair *only)
{
    picture p = picture_make(c->width, c->height);
    size_t count = pixels_of(&p), i;
    lflare_pair *pairs = ghosts_of(&s->lens);
    lflare_override *hidden = (lflare_override *)allocate((size_t)s->lens.ghost_count, sizeof *hidden);
    float *rgba = (float *)allocate(count, 4 * sizeof(float));
    lflare_settings settings;
    lflare_error error;
    int32_t g;
    memset(&settings, 0, sizeof settings);
    settings.fnumber = c->fnumber;
    settings.blades = c->blades;
    settings.raw = settings.no_starburst = settings.no_ringing = 1; /* as exact rays have it */
    settings.model = model;
    settings.overrides = hidden;
    for (g = 0; only != NULL && g < s->lens.ghost_count; g++) {
        lflare_override *o = &hidden[settings.override_count];
        if (pairs[g].first == only->first && pairs[g].second == only->second) continue;
        o->first = pairs[g].first + 1;
        o->second = pairs[g].second + 1;
        o->hide = 1;
        settings.override_count++;
    }
    if (lflare_configure(s->flare, &settings, &error) != LFLARE_OK) complain("%s: %s", s->name, error.text);
    draw_frame(s, c, rgba);
    for (i = 0; i < count; i++) memcpy(p.rgb + 3 * i, rgba + 4 * i, 3 * sizeof(float));
    free(rgba);
    free(hidden);
    free(pairs);
    return p;
}

/* ---- the worst ghosts ---- */

typedef struct harm {
    lflare_pair pair;
    double psnr;
} harm;

static int by_harm(const void *a, const void *b)
{
    const harm *x = (const harm *)a, *y = (const harm *)b;
    if (x->psnr != y->psnr) return x->psnr < y->psnr ? -1 : 1;
    return x->pair.first != y->pair.first ? x->pair.first - y->pair.first : x->pair.second - y->pair.second;
}

static double ghost_harm(subject *s, const scene *c, lflare_model model, const lflare_pair *pair, const picture *whole, float white)
{
    picture reference = reference_of(s, c, pair), drawn = draw(s, c, model, pair);
    double psnr = harm_of(whole, white, &reference, &drawn);
    free(reference.rgb);
    free(drawn.rgb);
    return psnr;
}

static void print_ghost(subject *s, const scene *c, const harm *h, const picture *whole, float white)
{
    picture reference = reference_of(s, c, &h->pair);
    double light = light_of(&reference);
    char pair[32];
    int k;
    sprintf(pair, "%d,%d", (int)h->pair.first + 1, (int)h->pair.second + 1);
    printf("      ghost %-6s", pair);
    for (k = MODELS - 1; k >= 0; k--) {
        picture drawn = draw(s, c, models[k], &h->pair);
        printf("  %s: in place %.2f, alone ", model_names[k], harm_of(whole, white, &reference, &drawn));
        if (light > 0) printf("%.2f dB, light %.3f", compare(&reference, &drawn).psnr, light_of(&drawn) / light);
        else printf("dark, light %.2g", light_of(&drawn) / light_of(whole));
        free(drawn.rgb);
    }
    putchar('\n');
    free(reference.rgb);
}

/* The ghosts whose pictures by a model do most harm to the whole, each in place of its own reference. */
static void print_worst(subject *s, const scene *c, lflare_model model, const picture *whole)
{
    lflare_pair *pairs = ghosts_of(&s->lens);
    harm *harms = (harm *)allocate((size_t)s->lens.ghost_count, sizeof *harms);
    float white = white_of(whole);
    int32_t g;
    for (g = 0; g < s->lens.ghost_count; g++) {
        harms[g].pair = pairs[g];
        harms[g].psnr = ghost_harm(s, c, model, &pairs[g], whole, white);
    }
    qsort(harms, (size_t)s->lens.ghost_count, sizeof *harms, by_harm);
    for (g = 0; g < WORST && g < s->lens.ghost_count && harms[g].psnr < HUGE_VAL; g++) print_ghost(s, c, &harms[g], whole, white);
    free(harms);
    free(pairs);
}

/* ---- the table ---- */

typedef struct options {
    const char *only;
    int width, height, worst, traced, sweep, angle_count;
    double angles[MAX_ANGLES], fnumber; /* fnumber: below 0 for 8 and wide open */
} options;

typedef struct tally {
    double worst[MODELS], behind; /* behind: the most that the polynomial PSNR is below the paraxial */
    int pictures, dark, worse;
} tally;

static const tally tally_none = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, 0, 0, 0, 0};

static void tally_add(tally *t, const likeness *found)
{
    int k;
    for (k = 0; k < MODELS; k++) t->worst[k] = fmin(t->worst[k], found[k].psnr);
    t->pictures++;
    if (found[POLYNOMIAL].psnr < found[PARAXIAL].psnr) {
        t->worse++;
        t->behind = fmax(t->behind, found[PARAXIAL].psnr - found[POLYNOMIAL].psnr);
    }
}

/* A model may light what is dark: its mean irradiance. */
static void print_dark(subject *s, const scene *c)
{
    int k;
    for (k = 0; k < MODELS; k++) {
        picture drawn = draw(s, c, models[k], NULL);
        double mean = light_of(&drawn) / (3 * (double)pixels_of(&drawn));
        char lit[32] = "";
        if (mean > 0) sprintf(lit, "; lit %.2g", mean);
        printf("   dark%-18s", lit);
        free(drawn.rgb);
    }
    putchar('\n');
}

/* One row. */
static void measure(subject *s, const scene *c, const options *o, tally *t)
{
    picture reference = reference_of(s, c, NULL);
    likeness found[MODELS];
    char stop[32] = "open", iris[32] = "round";
    int k;
    if (c->fnumber > 0) sprintf(stop, "f/%g", c->fnumber);
    if (c->blades > 0) sprintf(iris, "%d blades", c->blades);
    printf("%-6s %-8s %5g %-8s", stop, iris, c->angle, way_names[c->diagonal]);
    if (light_of(&reference) > 0) {
        for (k = 0; k < MODELS; k++) {
            picture drawn = draw(s, c, models[k], NULL);
            found[k] = compare(&reference, &drawn);
            printf("   %6.2f %6.2f %8.5f", found[k].psnr, found[k].linear, found[k].ssim);
            free(drawn.rgb);
        }
        printf("%s\n", found[POLYNOMIAL].psnr < found[PARAXIAL].psnr ? "  worse" : "");
        fflush(stdout);
        tally_add(t, found);
        if (o->worst) print_worst(s, c, o->traced ? LFLARE_MODEL_TRACED : LFLARE_MODEL_POLYNOMIAL, &reference);
    } else {
        print_dark(s, c);
        t->dark++;
    }
    fflush(stdout);
    free(reference.rgb);
}

/* All rows of a lens; the first lens of the table has one more, with blades. */
static void measure_lens(subject *s, const options *o, int blades_too, tally *t)
{
    static const double both[2] = {8, 0};
    int n, a, k, fnumbers = o->fnumber < 0 ? 2 : 1;
    printf("%-30s", "");
    for (k = 0; k < MODELS; k++) printf("   %-22s", model_names[k]);
    printf("\nstop   iris     angle along    ");
    for (k = 0; k < MODELS; k++) printf("     PSNR linear     SSIM");
    printf("\n");
    for (n = 0; n < fnumbers; n++)
        for (a = 0; a < o->angle_count; a++)
            for (k = 0; k < 2; k++) {
                scene c;
                c.angle = o->angles[a];
                c.diagonal = k;
                c.fnumber = o->fnumber < 0 ? both[n] : o->fnumber;
                c.blades = 0;
                c.width = o->width;
                c.height = o->height;
                measure(s, &c, o, t);
                if (!blades_too || k == 0 || fabs(c.angle - 13.4) > 1e-9 || fabs(c.fnumber - 8) > 1e-9) continue;
                c.blades = 5;
                measure(s, &c, o, t);
            }
}

/* ---- motion ---- */

/* What changes from one picture to another, as a share of the first one's light. */
static double change(const picture *a, const picture *b)
{
    double sum = 0;
    size_t i;
    for (i = 0; i < 3 * pixels_of(a); i++) sum += fabs((double)(b->rgb[i] - a->rgb[i]));
    return sum / light_of(a);
}

/* A light that moves out diagonally, 0.05 degrees at a time. */
static void sweep(subject *s, const options *o)
{
    enum { DRAWN = 2, ALL };
    static const lflare_model drawn[DRAWN] = {LFLARE_MODEL_POLYNOMIAL, LFLARE_MODEL_TRACED};
    picture before[ALL], now[ALL]; /* the last: exact rays' */
    double worst[DRAWN] = {0, 0}, at[DRAWN] = {0, 0}, mean[ALL] = {0, 0, 0};
    scene c;
    int i, k, m;
    memset(&c, 0, sizeof c);
    c.fnumber = o->fnumber < 0 ? 8 : o->fnumber;
    c.diagonal = 1;
    c.width = o->width / 4;
    c.height = o->height / 4;
    for (i = 0; i <= SWEEP; i++) {
        double changed[ALL];
        c.angle = 2 + 0.05 * i;
        now[DRAWN] = picture_make(c.width, c.height);
        render_reference(s, &c, NULL, SWEEP_CELLS, &now[DRAWN]);
        for (m = 0; m < DRAWN; m++) {
            now[m] = draw(s, &c, drawn[m], NULL);
            for (k = 0; k < 3 * (int)pixels_of(&now[m]); k++)
                if (!(now[m].rgb[k] >= 0 && now[m].rgb[k] < 1e30f)) complain("%s at %g degrees: a pixel is %g", s->name, c.angle, (double)now[m].rgb[k]);
        }
        for (k = 0; k < ALL && i > 0; k++) {
            changed[k] = change(&before[k], &now[k]);
            mean[k] += changed[k] / SWEEP;
            free(before[k].rgb);
        }
        for (m = 0; m < DRAWN && i > 0; m++)
            if (changed[m] / changed[DRAWN] > worst[m]) worst[m] = changed[m] / changed[DRAWN], at[m] = c.angle;
        memcpy(before, now, sizeof before);
    }
    for (k = 0; k < ALL; k++) free(before[k].rgb);
    for (m = 0; m < DRAWN; m++)
        printf("%s, %d places, f/%g, %d x %d: %.4f of the light changes from one to the next, %.4f of exact rays'; most against theirs %.3f, at %.2f degrees\n",
               model_names[POLYNOMIAL + m], (int)SWEEP, c.fnumber, c.width, c.height, mean[m], mean[DRAWN], worst[m], at[m]);
}

/* ---- command line ---- */

static double number(const char *option, const char *text, size_t size, double lo, double hi)
{
    double value;
    if (!lflare_number_read(text, size, &value) || !(value >= lo && value <= hi))
        complain("%s: a number from %g to %g was expected, not '%.*s'", option, lo, hi, (int)size, text);
    return value;
}

static void read_size(const char *text, options *o)
{
    size_t n = strcspn(text, "x");
    if (text[n] == 0) complain("--size: two numbers joined by 'x' were expected, not '%s'", text);
    o->width = (int)number("--size", text, n, 1, 16384);
    o->height = (int)number("--size", text + n + 1, strlen(text + n + 1), 1, 16384);
}

static void read_angles(const char *text, options *o)
{
    for (o->angle_count = 0; *text != 0; o->angle_count++) {
        size_t n = strcspn(text, ",");
        if (o->angle_count == MAX_ANGLES) complain("--angles: at most %d", (int)MAX_ANGLES);
        o->angles[o->angle_count] = number("--angles", text, n, 0, 89);
        text += n + (text[n] == ',');
    }
}

static options parse(int argc, char **argv)
{
    options o;
    int i;
    memset(&o, 0, sizeof o);
    o.only = "";
    o.width = 1280;
    o.height = 720;
    o.fnumber = -1;
    read_angles("5.45,13.4,20", &o);
    for (i = 1; i < argc; i++) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(name, "--help") == 0) {
            fputs(help, stdout);
            exit(0);
        }
        if (strcmp(name, "--worst") == 0) { o.worst = 1; continue; }
        if (strcmp(name, "--traced") == 0) { o.traced = 1; continue; }
        if (strcmp(name, "--sweep") == 0) { o.sweep = 1; continue; }
        if (strcmp(name, "--only") == 0) o.only = value;
        else if (strcmp(name, "--size") == 0) read_size(value, &o);
        else if (strcmp(name, "--angles") == 0) read_angles(value, &o);
        else if (strcmp(name, "--fnumber") == 0) o.fnumber = number(name, value, strlen(value), 0, 1000);
        else complain("unknown option '%s'; see --help", name);
        if (++i == argc) complain("%s: a value is missing", name);
    }
    return o;
}

int main(int argc, char **argv)
{
    static const char *const names[] = {"heliar-tronnier", "angenieux-double-gauss", "nikon-80-200-mid",
                                        "canon-70-200-mid", "distagon-25", "biogon-35-28"};
    enum { LENSES = sizeof names / sizeof names[0] };
    static subject s;
    options o = parse(argc, argv);
    tally tallies[LENSES], sum = tally_none;
    int i;
    if (mkdir("build", 0777) != 0 && errno != EEXIST) complain("build: %s", strerror(errno));
    if (mkdir(FOLDER, 0777) != 0 && errno != EEXIST) complain(FOLDER ": %s", strerror(errno));
    printf("PSNR in dB over lit pixels (tone-mapped, linear) and SSIM against exact rays, %d x %d\n", o.width, o.height);
    for (i = 0; i < LENSES; i++) {
        tallies[i] = tally_none;
        if (strstr(names[i], o.only) == NULL) continue;
        memset(&s, 0, sizeof s);
        s.name = names[i];
        putchar('\n');
        open_subject(&s);
        if (o.sweep) sweep(&s, &o);
        else measure_lens(&s, &o, i == 0, &tallies[i]);
        close_subject(&s);
        sum.pictures += tallies[i].pictures;
        sum.dark += tallies[i].dark;
        sum.worse += tallies[i].worse;
        sum.behind = fmax(sum.behind, tallies[i].behind);
    }
    if (o.sweep) return 0;
    if (sum.pictures + sum.dark == 0) complain("--only: no lens of the table has '%s' in its name", o.only);
    printf("\n%-24s %10s %10s %10s\n", "worst PSNR", model_names[PARAXIAL], model_names[POLYNOMIAL], model_names[TRACED]);
    for (i = 0; i < LENSES; i++)
        if (tallies[i].pictures > 0) printf("%-24s %10.2f %10.2f %10.2f\n", names[i], tallies[i].worst[PARAXIAL], tallies[i].worst[POLYNOMIAL], tallies[i].worst[TRACED]);
    printf("polynomial worse than paraxial in %d of %d pictures, by %.2f dB at most; %d more are dark\n", sum.worse, sum.pictures, sum.behind,
           sum.dark);
    return 0;
}
