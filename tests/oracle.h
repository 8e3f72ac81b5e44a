/* The tests' own physics. It shares nothing with the library but the plain prescription struct: indices, paraxial and exact
   rays, and films are worked out here anew, in long double where rounding matters, films by Airy's summation of the
   beams between interfaces (the library multiplies characteristic matrices). */

#ifndef TESTS_ORACLE_H
#define TESTS_ORACLE_H

#include <complex.h>
#include <float.h>
#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ORACLE_PI 3.14159265358979323846264338327950288L
#define ORACLE_D 587.5618

enum { ORACLE_STEPS = 5 * LFLARE_MAX_SURFACES };

/* ---- random numbers: the same everywhere ---- */

typedef struct oracle_random {
    uint64_t state;
} oracle_random;

static inline double oracle_unit(oracle_random *r) /* 0 <= x < 1 */
{
    uint64_t x;
    r->state += 0x9fb21c651e98df25u;
    x = r->state;
    x ^= x >> 29;
    x *= 0xd6e8feb86659fd93u;
    x ^= x >> 32;
    x *= 0xd6e8feb86659fd93u;
    x ^= x >> 31;
    return (double)(x >> 11) / 9007199254740992.0;
}

static inline double oracle_between(oracle_random *r, double lo, double hi) { return lo + (hi - lo) * oracle_unit(r); }

/* ---- indices ---- */

static inline long double oracle_index(const lflare_medium *m, double nm)
{
    long double l = (long double)nm / 1000, c0 = (long double)m->c[0], c1 = (long double)m->c[1];
    if (m->kind == LFLARE_MEDIUM_CONSTANT) return c0;
    if (m->kind == LFLARE_MEDIUM_ABBE) { /* A + B / l^2 with n_F - n_C = (n_d - 1) / V_d */
        long double f = 0.4861327L, d = 0.5875618L, c = 0.6562725L;
        long double b = (c0 - 1) / c1 * f * f * c * c / (c * c - f * f);
        return c0 - b / (d * d) + b / (l * l);
    }
    if (m->kind == LFLARE_MEDIUM_SELLMEIER) {
        long double sum = 1;
        int i;
        for (i = 0; i < 3; i++) sum += (long double)m->c[i] / (1 - (long double)m->c[i + 3] / (l * l));
        return sqrtl(sum);
    }
    if (m->kind == LFLARE_MEDIUM_CAUCHY) return c0 + (c1 + (long double)m->c[2] / (l * l)) / (l * l);
    return 1;
}

/* ---- a lens at one wavelength ---- */

typedef struct oracle_lens {
    const lflare_prescription *p;
    double nm;
    int count, stop;
    long double n[LFLARE_MAX_SURFACES + 1]; /* in front of surface i */
    long double curvature[LFLARE_MAX_SURFACES]; /* at the vertex */
} oracle_lens;

static inline void oracle_lens_make(oracle_lens *o, const lflare_prescription *p, double nm)
{
    int i;
    o->p = p;
    o->nm = nm;
    o->count = p->surface_count;
    o->stop = -1;
    o->n[0] = 1;
    for (i = 0; i < o->count; i++) {
        const lflare_surface *s = &p->surfaces[i];
        if (s->is_stop) o->stop = i;
        o->n[i + 1] = s->is_stop ? o->n[i] : oracle_index(&s->medium, nm);
        o->curvature[i] = 2 * (long double)s->aspheric[0];
        if (s->radius != 0) o->curvature[i] += 1 / (long double)s->radius;
    }
}

/* ---- paths ---- */

typedef struct oracle_step {
    int surface, backwards, reflects;
    long double gap; /* to the next step's vertex, or the sensor */
} oracle_step;

/* The order in which light meets the surfaces on its way through an even number of reflections. */
static inline int oracle_path_of(const oracle_lens *o, const int *turns, int count, oracle_step *out)
{
    int n = 0, i, leg, from = 0;
    for (leg = 0; leg <= count; leg++) {
        int back = leg % 2, to = leg < count ? turns[leg] : o->count - 1;
        for (i = from; back ? i >= to : i <= to; i += back ? -1 : 1, n++) {
            out[n].surface = i;
            out[n].backwards = back;
            out[n].reflects = leg < count && i == to;
        }
        from = back ? to + 1 : to - 1;
    }
    for (i = 0; i < n; i++) { /* the gap belongs to the surface in front of it */
        int k = out[i].surface, leaves_backwards = out[i].backwards != out[i].reflects;
        out[i].gap = (long double)o->p->surfaces[leaves_backwards ? k - 1 : k].thickness;
    }
    return n;
}

/* The same of two; first < 0 is the direct path. */
static inline int oracle_path(const oracle_lens *o, int first, int second, oracle_step *out)
{
    int turns[2];
    turns[0] = first;
    turns[1] = second;
    return oracle_path_of(o, turns, first < 0 ? 0 : 2, out);
}

/* ---- paraxial rays, in the unfolded frame ---- */

typedef struct oracle_matrix {
    long double a, b, c, d;
} oracle_matrix;

static inline oracle_matrix oracle_times(oracle_matrix l, oracle_matrix r)
{
    oracle_matrix m;
    m.a = l.a * r.a + l.b * r.c;
    m.b = l.a * r.b + l.b * r.d;
    m.c = l.c * r.a + l.d * r.c;
    m.d = l.c * r.b + l.d * r.d;
    return m;
}

/* What a crossing does to (height, slope), and the matrix of the gap behind it. */
static inline oracle_matrix oracle_crossing_matrix(const oracle_lens *o, const oracle_step *s)
{
    oracle_matrix m = {1, 0, 0, 1};
    long double c = s->backwards ? -o->curvature[s->surface] : o->curvature[s->surface];
    long double n1 = o->n[s->surface + s->backwards], n2 = o->n[s->surface + 1 - s->backwards];
    if (s->reflects) {
        m.c = 2 * c;
    } else {
        m.c = (n1 - n2) * c / n2;
        m.d = n1 / n2;
    }
    return m;
}

static inline oracle_matrix oracle_gap_matrix(const oracle_step *s)
{
    oracle_matrix m = {1, 0, 0, 1};
    m.b = s->gap;
    return m;
}

/* at[i]: from the entrance to just before step i; at[count]: to the sensor. */
static inline void oracle_paraxial(const oracle_lens *o, const oracle_step *path, int count, oracle_matrix *at)
{
    int i;
    at[0].a = at[0].d = 1;
    at[0].b = at[0].c = 0;
    for (i = 0; i < count; i++) at[i + 1] = oracle_times(oracle_gap_matrix(&path[i]), oracle_times(oracle_crossing_matrix(o, &path[i]), at[i]));
}

/* ---- exact rays ---- */

typedef struct oracle_ray {
    long double stop[2], sensor[2];
    long double cosine[ORACLE_STEPS]; /* of incidence, at each step */
    long double height[ORACLE_STEPS]; /* from the axis, at each step */
} oracle_ray;

/* Where p + t d meets the sheet through the vertex at the origin; the normal there, along d. 0 if they miss. */
static inline int oracle_meet(const lflare_surface *s, long double *p, const long double *d, long double sense, long double *normal)
{
    long double c = s->radius != 0 ? 1 / (long double)s->radius : 0, e = 1 + (long double)s->conic;
    long double b = d[2] - c * (p[0] * d[0] + p[1] * d[1] + e * p[2] * d[2]);
    long double q = c * (p[0] * p[0] + p[1] * p[1] + e * p[2] * p[2]) - 2 * p[2];
    long double dd = d[0] * d[0] + d[1] * d[1] + e * d[2] * d[2], root = b * b - c * dd * q, t, length;
    int i, k, bent = 0;
    if (!(root >= 0)) return 0;
    t = q / (b + sense * sqrtl(root));
    for (i = 0; i < 3; i++) p[i] += t * d[i];
    for (i = 0; i < 8; i++) bent |= s->aspheric[i] != 0;
    normal[0] = -c * p[0];
    normal[1] = -c * p[1];
    normal[2] = 1 - c * e * p[2];
    if (!bent && !(normal[2] > 0)) return 0; /* past the equator is another sheet */
    for (k = 0; bent && k < 60; k++) { /* Newton on z - sag(x^2 + y^2) */
        long double r2 = p[0] * p[0] + p[1] * p[1], inner = 1 - e * c * c * r2, sag, slope, power = 1, f, df;
        if (!(inner > 0)) return 0;
        sag = c * r2 / (1 + sqrtl(inner));
        slope = c / (2 * sqrtl(inner)); /* d sag / d r2 */
        for (i = 0; i < 8; i++) {
            slope += (i + 1) * (long double)s->aspheric[i] * power;
            power *= r2;
            sag += (long double)s->aspheric[i] * power;
        }
        normal[0] = -2 * slope * p[0];
        normal[1] = -2 * slope * p[1];
        normal[2] = 1;
        f = p[2] - sag;
        df = normal[0] * d[0] + normal[1] * d[1] + d[2];
        t = f / df;
        for (i = 0; i < 3; i++) p[i] -= t * d[i];
        if (fabsl(t) < 1e-19L) break;
    }
    length = sqrtl(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]) * sense;
    for (i = 0; i < 3; i++) normal[i] /= length;
    return 1;
}

/* From (x, y) on the plane of the first vertex with slopes (ux, uy), surface after surface whatever the sign of the ray's
   parameter. 0 if a surface is missed or reflects totally. */
static inline int oracle_trace(const oracle_lens *o, const oracle_step *path, int count, const long double *at, const long double *slope, oracle_ray *out)
{
    long double p[3], d[3], normal[3], length = sqrtl(1 + slope[0] * slope[0] + slope[1] * slope[1]), t;
    int i, k;
    for (k = 0; k < 2; k++) {
        p[k] = at[k];
        d[k] = slope[k] / length;
    }
    p[2] = 0;
    d[2] = 1 / length;
    for (i = 0; i < count; i++) { /* p is relative to the vertex of this step's surface */
        const lflare_surface *s = &o->p->surfaces[path[i].surface];
        long double sense = path[i].backwards ? -1 : 1, cosine, n1 = o->n[path[i].surface + path[i].backwards], n2 = o->n[path[i].surface + 1 - path[i].backwards];
        if (!(d[2] * sense > 0) || !oracle_meet(s, p, d, sense, normal)) return 0;
        cosine = d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2];
        out->cosine[i] = cosine;
        out->height[i] = sqrtl(p[0] * p[0] + p[1] * p[1]);
        if (s->is_stop) {
            out->stop[0] = p[0];
            out->stop[1] = p[1];
        }
        if (path[i].reflects) {
            for (k = 0; k < 3; k++) d[k] -= 2 * cosine * normal[k];
        } else {
            long double ratio = n1 / n2, sine2 = ratio * ratio * (1 - cosine * cosine), add;
            if (!(sine2 < 1)) return 0;
            add = sqrtl(1 - sine2) - ratio * cosine;
            for (k = 0; k < 3; k++) d[k] = ratio * d[k] + add * normal[k];
        }
        p[2] -= path[i].backwards != path[i].reflects ? -path[i].gap : path[i].gap;
    }
    t = -p[2] / d[2];
    for (k = 0; k < 2; k++) out->sensor[k] = p[k] + t * d[k];
    return d[2] > 0;
}

/* ---- films ---- */

/* Power reflectance, unpolarised, of layers between n0 and n1 at n0 sin(theta0) = s, by adding up from the far side the
   beams that each layer returns. */
static inline double oracle_film(double n0, double n1, const lflare_layer *layers, int count, double nm, double s)
{
    double sum = 0;
    int polarisation, i;
    for (polarisation = 0; polarisation < 2; polarisation++) {
        double complex kz[LFLARE_MAX_LAYERS + 2], r = 0; /* n cos(theta); positive imaginary where the wave decays */
        double n[LFLARE_MAX_LAYERS + 2];
        for (i = 0; i < count + 2; i++) {
            double square;
            n[i] = i == 0 ? n0 : i == count + 1 ? n1 : layers[i - 1].n;
            square = (n[i] - s) * (n[i] + s);
            kz[i] = square >= 0 ? sqrt(square) : sqrt(-square) * (double complex)I;
        }
        for (i = count; i >= 0; i--) {
            double complex a = polarisation ? n[i + 1] * n[i + 1] * kz[i] : kz[i], b = polarisation ? n[i] * n[i] * kz[i + 1] : kz[i + 1];
            double complex own = a + b == 0 ? 0 : (a - b) / (a + b), lag = 1;
            if (i < count) lag = cexp(2 * (double complex)I * (2 * (double)ORACLE_PI / nm) * kz[i + 1] * layers[i].thickness_nm);
            r = (own + r * lag) / (1 + own * r * lag);
        }
        sum += creal(r) * creal(r) + cimag(r) * cimag(r);
    }
    return sum / 2;
}

/* The film on a surface, from its front side. A quarter-wave layer is made for the indices at its own wavelength. */
static inline int oracle_layers(const lflare_prescription *p, int surface, lflare_layer *out)
{
    const lflare_surface *s = &p->surfaces[surface];
    oracle_lens o;
    int i;
    if (s->coating == LFLARE_COATING_STACK) {
        for (i = 0; i < s->layer_count; i++) out[i] = p->layers[s->first_layer + i];
        return s->layer_count;
    }
    if (s->coating != LFLARE_COATING_QUARTER) return 0;
    oracle_lens_make(&o, p, s->quarter_nm);
    out->n = (double)sqrtl(o.n[surface] * o.n[surface + 1]);
    if (out->n < 1.38) out->n = 1.38;
    out->thickness_nm = s->quarter_nm / 4 / out->n;
    return 1;
}

/* W of a path for the paraxial ray from a height with a slope (both along one line): Snell's law exact from the paraxial
   tangent of incidence on. */
static inline double oracle_weight(const oracle_lens *o, const oracle_step *path, int count, const oracle_matrix *at, double height, double slope)
{
    long double r = (long double)height, u = (long double)slope;
    lflare_layer layers[LFLARE_MAX_LAYERS], turned[LFLARE_MAX_LAYERS];
    double w = 1;
    int i, k;
    for (i = 0; i < count; i++) {
        int s = path[i].surface, used = oracle_layers(o->p, s, layers);
        double n1 = (double)o->n[s + path[i].backwards], n2 = (double)o->n[s + 1 - path[i].backwards], film;
        long double c = path[i].backwards ? -o->curvature[s] : o->curvature[s];
        long double tangent = (at[i].c * r + at[i].d * u) + c * (at[i].a * r + at[i].b * u);
        if (o->p->surfaces[s].is_stop || (n1 == n2 && used == 0)) continue;
        for (k = 0; k < used; k++) turned[k] = layers[path[i].backwards ? used - 1 - k : k];
        film = oracle_film(n1, n2, turned, used, o->nm, n1 * (double)(tangent / sqrtl(1 + tangent * tangent)));
        w *= path[i].reflects ? film : 1 - film;
    }
    return w;
}

/* ---- files ---- */

static inline char *oracle_read(const char *path) /* with a zero behind it; NULL if there is none */
{
    FILE *f = fopen(path, "rb");
    char *text = NULL;
    size_t size = 0, got;
    if (f == NULL) return NULL;
    do {
        char *grown = (char *)realloc(text, size + 65537);
        if (grown == NULL) abort();
        text = grown;
        got = fread(text + size, 1, 65536, f);
        size += got;
    } while (got > 0);
    fclose(f);
    text[size] = 0;
    return text;
}

/* Behind the next "key": at or after *at, NULL if there is none. */
static inline const char *oracle_json_find(const char *at, const char *key)
{
    char quoted[64];
    const char *found;
    if (at == NULL) return NULL;
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    found = strstr(at, quoted);
    return found != NULL ? found + strlen(quoted) : NULL;
}

/* `count` numbers behind the next such key, brackets and commas skipped. Moves *at behind them. */
static inline int oracle_json_numbers(const char **at, const char *key, double *out, int count)
{
    const char *p = oracle_json_find(*at, key);
    int i;
    for (i = 0; p != NULL && i < count; i++) {
        char *end;
        p += strspn(p, " \t\r\n[,");
        out[i] = strtod(p, &end);
        if (end == p) return 0;
        p = end;
    }
    if (p == NULL) return 0;
    *at = p;
    return 1;
}

/* ---- the lenses to test ---- */

enum { ORACLE_MAX_LENSES = 64 };

typedef struct oracle_lenses {
    char path[ORACLE_MAX_LENSES][256];
    int count;
} oracle_lenses;

static inline void oracle_lenses_add(oracle_lenses *l, const char *pattern)
{
    glob_t g;
    size_t i;
    if (glob(pattern, 0, NULL, &g) == 0) {
        for (i = 0; i < g.gl_pathc && l->count < ORACLE_MAX_LENSES; i++) snprintf(l->path[l->count++], sizeof l->path[0], "%s", g.gl_pathv[i]);
        globfree(&g);
    }
}

/* Every lens of the collection and the two of the golden numbers. */
static inline void oracle_lenses_find(oracle_lenses *l)
{
    l->count = 0;
    oracle_lenses_add(l, "lenses/*.lens");
    oracle_lenses_add(l, "tests/data/*-golden.lens");
}

/* Reads and derives a lens; 0 and a message if that fails. */
static inline int oracle_lens_load(const char *path, lflare_lens *out)
{
    lflare_prescription *p = (lflare_prescription *)malloc(sizeof *p);
    char *text = oracle_read(path);
    lflare_error error;
    int ok;
    memset(&error, 0, sizeof error);
    ok = p != NULL && text != NULL && lflare_text_read(text, strlen(text), p, &error) == LFLARE_OK && lflare_lens_derive(p, out, &error) >= 0;
    if (!ok) fprintf(stderr, "%s: line %d: %s\n", path, (int)error.line, text == NULL ? "cannot be read" : error.text);
    free(text);
    free(p);
    return ok;
}

#endif
