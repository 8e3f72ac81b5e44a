/* The reference picture: dense meshes of exact rays over the library's public trace, slow and independent of everything that
   makes the library fast. Every ghost's entrance is cut into cells, every cell's power spread over its image on the sensor
   (Hullin et al. 2011, but by exact areas): folds, caustics and cells smaller than a pixel keep their energy. A point of light,
   no penumbra. A ghost whose open entrance is narrower than 1/200 of the front element may be missed.
   flare.c and the tests include it; it uses all cores where there are POSIX threads, and the picture is the same to the bit
   whatever their number. Include lensflare.h with its implementation first. */
#ifndef REFERENCE_H
#define REFERENCE_H

#include <math.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#ifndef _WIN32
#include <pthread.h>
#include <unistd.h>
#endif

enum { REFERENCE_MAX_WAVELENGTHS = 256, REFERENCE_MAX_THREADS = 64, REFERENCE_DEPTH = 3 };

/* Where rays land farther from the picture than this (pixels), they count as lost: coordinates stay exact, and fit an int. */
#define REFERENCE_FAR 1e8

typedef struct reference_desc {
    const lflare_lens *lens;
    const lflare_iris *iris;
    double slope[2];            /* of the light, as the lens sees it */
    double half[2], centre[2];  /* of the frame on the sensor, mm: as in lflare_frame_data */
    int width, height;
    int wavelengths;
    double nm[REFERENCE_MAX_WAVELENGTHS];
    double rgb[REFERENCE_MAX_WAVELENGTHS][3]; /* what a wavelength adds to each channel; negative is fine */
    int cells;                  /* along a side of a ghost's entrance; 96 is a good start */
    int threads;                /* 0 = one a core */
    const lflare_pair *only;    /* one ghost alone, or NULL */
    volatile sig_atomic_t *stop; /* set it, in a signal handler say, to end early; may be NULL */
    void (*progress)(void *user, double done); /* 0 to 1, from the calling thread; may be NULL */
    void *user;
} reference_desc;

typedef struct reference_vertex {
    double entrance[2], place[2]; /* place: on the picture, pixels from the top left corner */
    double open, weight;          /* open: above 0 the ray passes every rim and the iris, linear near 0 */
    int arrives;
} reference_vertex;

/* One job, a ghost at one wavelength, in a thread of its own. */
typedef struct reference_worker {
    const reference_desc *d;
    lflare_path path;
    double *steps;          /* the job's picture, as differences along rows of width + 2 */
    int rows[2];            /* first and last row touched */
    int failed;
} reference_worker;

/* ---- areas ---- */

/* Seen from the first corner: far from the origin, products of coordinates would drown a small area. */
static double reference_area(double p[][2], int n)
{
    double a = 0;
    int i;
    for (i = 1; i + 1 < n; i++) a += (p[i][0] - p[0][0]) * (p[i + 1][1] - p[0][1]) - (p[i + 1][0] - p[0][0]) * (p[i][1] - p[0][1]);
    return 0.5 * a;
}

/* Keeps the side where sign * (coordinate - limit) <= 0; returns the number of corners. */
static int reference_cut(double in[][2], int n, int axis, double limit, double sign, double out[][2])
{
    int i, m = 0;
    for (i = 0; i < n; i++) {
        double *a = in[i], *b = in[(i + 1) % n], da = sign * (a[axis] - limit), db = sign * (b[axis] - limit);
        if (da <= 0) {
            out[m][0] = a[0];
            out[m++][1] = a[1];
        }
        if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
            double t = da / (da - db);
            out[m][0] = a[0] + t * (b[0] - a[0]);
            out[m++][1] = a[1] + t * (b[1] - a[1]);
        }
    }
    return m;
}

static void reference_touch(reference_worker *w, int row)
{
    if (row < w->rows[0]) w->rows[0] = row;
    if (row > w->rows[1]) w->rows[1] = row;
}

/* A value that holds in one pixel alone, as two differences. */
static void reference_pixel(reference_worker *w, int x, int y, double value)
{
    double *row;
    if (x < 0 || y < 0 || x >= w->d->width || y >= w->d->height) return;
    row = w->steps + (size_t)y * (size_t)(w->d->width + 2);
    row[x] += value;
    row[x + 1] -= value;
    reference_touch(w, y);
}

/* Narrows the part t[0] to t[1] of a line from a to b to where the coordinate is between 0 and limit. */
static void reference_clip(double a, double b, double limit, double *t)
{
    if (a != b) {
        double at0 = -a / (b - a), at1 = (limit - a) / (b - a);
        t[0] = fmax(t[0], fmin(at0, at1));
        t[1] = fmin(t[1], fmax(at0, at1));
    } else if (a < 0 || a > limit) {
        t[1] = t[0];
    }
}

/* Power where the image has no area worth the name: along its longest side, what falls outside the picture left out. */
static void reference_line(reference_worker *w, double p[][2], int n, double power)
{
    int i, j, count, k;
    double *a = p[0], *b = p[0], longest = 0, t[2] = {0, 1};
    for (i = 0; i < n; i++)
        for (j = 0; j < i; j++) {
            double length = hypot(p[i][0] - p[j][0], p[i][1] - p[j][1]);
            if (length > longest) longest = length, a = p[i], b = p[j];
        }
    reference_clip(a[0], b[0], w->d->width, t);
    reference_clip(a[1], b[1], w->d->height, t);
    if (!(t[1] > t[0])) return;
    power *= t[1] - t[0];
    count = 1 + (int)(8 * longest * (t[1] - t[0]));
    for (k = 0; k < count; k++) {
        double at = t[0] + (t[1] - t[0]) * (k + 0.5) / count;
        reference_pixel(w, (int)floor(a[0] + at * (b[0] - a[0])), (int)floor(a[1] + at * (b[1] - a[1])), power / count);
    }
}

/* One edge's part of the area to its right, in each pixel of the rows it crosses: differences along the row add up to it. */
static void reference_edge(reference_worker *w, const double *a, const double *b, double value)
{
    double x0 = a[0], y0 = a[1], x1 = b[0], y1 = b[1], width = w->d->width;
    int y, last;
    if (y0 == y1) return;
    if (y0 > y1) {
        double t = x0;
        x0 = x1, x1 = t;
        t = y0, y0 = y1, y1 = t;
        value = -value;
    }
    last = (int)fmin(ceil(y1), w->d->height) - 1;
    for (y = (int)fmax(floor(y0), 0); y <= last; y++) {
        double ya = fmax(y0, y), yb = fmin(y1, y + 1), dy = yb - ya, xa, xb, x, span;
        double *row = w->steps + (size_t)y * (size_t)(w->d->width + 2);
        if (!(dy > 0)) continue;
        xa = x0 + (x1 - x0) * (ya - y0) / (y1 - y0);
        xb = x0 + (x1 - x0) * (yb - y0) / (y1 - y0);
        if (xa > xb) { double t = xa; xa = xb; xb = t; }
        reference_touch(w, y);
        if (xb <= 0) { row[0] += value * dy; continue; }
        if (xa >= width) continue;
        if (xa < 0) { /* the part left of the picture fills whole rows */
            double part = -xa / (xb - xa) * dy;
            row[0] += value * part;
            dy -= part;
            xa = 0;
        }
        if (xb > width) dy *= (width - xa) / (xb - xa), xb = width;
        span = xb - xa;
        for (x = floor(xa); x < xb || x == floor(xa); x++) { /* in this pixel column the edge covers [l, r] */
            double l = fmax(xa, x), r = fmin(xb, x + 1), part = span > 0 ? (r - l) / span * dy : dy, right = x + 1 - 0.5 * (l + r);
            row[(int)x] += value * part * right;
            row[(int)x + 1] += value * part * (1 - right);
            if (span <= 0) break;
        }
    }
}

/* Spreads power over a polygon on the picture. */
static void reference_fill(reference_worker *w, double p[][2], int n, double power)
{
    double area = reference_area(p, n), box[4] = {p[0][0], p[0][0], p[0][1], p[0][1]}, extent;
    int i;
    for (i = 1; i < n; i++) {
        box[0] = fmin(box[0], p[i][0]), box[1] = fmax(box[1], p[i][0]);
        box[2] = fmin(box[2], p[i][1]), box[3] = fmax(box[3], p[i][1]);
    }
    if (box[1] <= 0 || box[3] <= 0 || box[0] >= w->d->width || box[2] >= w->d->height) return;
    extent = fmax(box[1] - box[0], box[3] - box[2]);
    if (fabs(area) < 1e-9 || fabs(area) < 1e-4 * extent * fmin(extent, 1)) {
        reference_line(w, p, n, power);
    } else if (extent < 3) { /* few pixels: one by one, since differences of great values leave rounding errors behind */
        int x, y;
        for (y = (int)floor(box[2]); y < box[3]; y++)
            for (x = (int)floor(box[0]); x < box[1]; x++) {
                double a[16][2], b[16][2];
                int m = reference_cut(p, n, 0, x, -1, a);
                m = reference_cut(a, m, 0, x + 1, 1, b);
                m = reference_cut(b, m, 1, y, -1, a);
                m = reference_cut(a, m, 1, y + 1, 1, b);
                if (m > 2) reference_pixel(w, x, y, power * reference_area(b, m) / area);
            }
    } else {
        for (i = 0; i < n; i++) reference_edge(w, p[i], p[(i + 1) % n], -power / area);
    }
}

/* ---- rays ---- */

static double reference_iris_open(const lflare_iris *iris, const double *stop)
{
    double x = stop[0] / (double)iris->radius, y = stop[1] / (double)iris->radius, open = 1 - hypot(x, y);
    int i;
    if (iris->blade_count == 0) return open;
    open = 1;
    for (i = 0; i < iris->blade_count; i++) {
        const lflare_blade *b = &iris->blades[i];
        double nx = (double)b->nx, ny = (double)b->ny, far = (double)b->distance, arc = (double)b->arc;
        open = fmin(open, arc > 0 ? arc - hypot(x + nx * far, y + ny * far) : far - nx * x - ny * y);
    }
    return open;
}

static reference_vertex reference_trace(const reference_worker *w, double x, double y)
{
    const reference_desc *d = w->d;
    reference_vertex v;
    lflare_ray ray;
    int i;
    memset(&v, 0, sizeof v);
    v.entrance[0] = x;
    v.entrance[1] = y;
    v.arrives = lflare_path_trace(&w->path, v.entrance, d->slope, &ray, NULL) == LFLARE_RAY_ARRIVES;
    if (!v.arrives) return v;
    v.weight = ray.weight;
    v.open = 1 - ray.relative;
    for (i = 0; i < ray.stop_count; i++) v.open = fmin(v.open, reference_iris_open(d->iris, ray.stops[i])); /* blades and all, each time */
    v.place[0] = 0.5 * d->width * (1 - (ray.sensor[0] - d->centre[0]) / d->half[0]); /* the picture is the sensor turned round */
    v.place[1] = 0.5 * d->height * (1 + (ray.sensor[1] - d->centre[1]) / d->half[1]);
    v.arrives = fabs(v.place[0]) < REFERENCE_FAR && fabs(v.place[1]) < REFERENCE_FAR && v.open - v.open == 0;
    return v;
}

/* The open part of a triangle of rays. `power`: of an entrance area of 1 mm^2 and weight 1, in units of a pixel's. */
static void reference_triangle(reference_worker *w, const reference_vertex *a, const reference_vertex *b, const reference_vertex *c, double power)
{
    const reference_vertex *v[3] = {a, b, c};
    double places[8][2], entrance[8][2], weight = 0;
    int i, k, n = 0;
    for (i = 0; i < 3; i++) {
        const reference_vertex *p = v[i], *q = v[(i + 1) % 3];
        if (p->open > 0) {
            for (k = 0; k < 2; k++) places[n][k] = p->place[k], entrance[n][k] = p->entrance[k];
            weight += p->weight;
            n++;
        }
        if ((p->open > 0) != (q->open > 0)) {
            double t = p->open / (p->open - q->open);
            for (k = 0; k < 2; k++) {
                places[n][k] = p->place[k] + t * (q->place[k] - p->place[k]);
                entrance[n][k] = p->entrance[k] + t * (q->entrance[k] - p->entrance[k]);
            }
            weight += p->weight + t * (q->weight - p->weight);
            n++;
        }
    }
    if (n > 2) reference_fill(w, places, n, power * weight / n * fabs(reference_area(entrance, n)));
}

/* How far the image's middle is from where four corners put it, pixels: its bend. */
static double reference_bend(const reference_vertex *v, const reference_vertex *middle)
{
    double bend = 0;
    int i;
    for (i = 0; i < 2; i++) bend = fmax(bend, fabs(0.25 * (v[0].place[i] + v[1].place[i] + v[2].place[i] + v[3].place[i]) - middle->place[i]));
    return bend;
}

/* A cell with corners (0 0) (1 0) (1 1) (0 1); cut in four, `depth` times at most, where its image bends or rays are lost. What
   then still has a lost corner is dropped: a rim of cells 1/8 as wide. */
static void reference_cell(reference_worker *w, const reference_vertex *v, double power, int depth)
{
    reference_vertex m[5]; /* middle, then the sides' */
    int i, arriving = 0, open = 0, whole;
    double spread = 0;
    for (i = 0; i < 4; i++) {
        arriving += v[i].arrives;
        open += v[i].arrives && v[i].open > 0;
    }
    if (arriving == 0) return;
    m[0] = reference_trace(w, 0.5 * (v[0].entrance[0] + v[2].entrance[0]), 0.5 * (v[0].entrance[1] + v[2].entrance[1]));
    whole = arriving == 4 && m[0].arrives;
    if (whole && open == 0) { /* closed all over, as far as `open` is linear */
        for (i = 0; i < 4; i++) spread = fmax(spread, fabs(v[i].open - m[0].open));
        if (m[0].open + spread <= 0) return;
    }
    if (depth == 0 || (whole && reference_bend(v, &m[0]) <= 0.1)) {
        for (i = 0; i < 4 && whole; i++) reference_triangle(w, &v[i], &v[(i + 1) % 4], &m[0], power);
        return;
    }
    for (i = 0; i < 4; i++) {
        const reference_vertex *a = &v[i], *b = &v[(i + 1) % 4];
        m[1 + i] = reference_trace(w, 0.5 * (a->entrance[0] + b->entrance[0]), 0.5 * (a->entrance[1] + b->entrance[1]));
    }
    for (i = 0; i < 4; i++) {
        reference_vertex child[4];
        child[0] = v[i];
        child[1] = m[1 + i];
        child[2] = m[0];
        child[3] = m[1 + (i + 3) % 4];
        reference_cell(w, child, power, depth - 1);
    }
}

/* Shrinks a rectangle of the entrance to what a grid of n x n cells finds open in it and a cell round that; 0 if nothing is. */
static int reference_box(const reference_worker *w, int n, double *box)
{
    double found[4] = {1e300, -1e300, 1e300, -1e300}, dx = (box[1] - box[0]) / n, dy = (box[3] - box[2]) / n;
    int i, j;
    for (j = 0; j <= n; j++)
        for (i = 0; i <= n; i++) {
            double x = box[0] + i * dx, y = box[2] + j * dy;
            reference_vertex v = reference_trace(w, x, y);
            if (!v.arrives || v.open < 0) continue;
            found[0] = fmin(found[0], x), found[1] = fmax(found[1], x);
            found[2] = fmin(found[2], y), found[3] = fmax(found[3], y);
        }
    if (found[0] > found[1]) return 0;
    box[0] = found[0] - dx, box[1] = found[1] + dx;
    box[2] = found[2] - dy, box[3] = found[3] + dy;
    return 1;
}

/* The rectangle through which rays pass. A coarse grid meets a slanting sliver in a point or two, far from its ends: so what is
   found is enlarged and searched again, until it stays within. */
static int reference_entrance(const reference_worker *w, double reach, double *box)
{
    static const int grids[3] = {40, 90, 200};
    int i, k, seen = 0;
    for (i = 0; i < 3 && !seen; i++) {
        for (k = 0; k < 4; k++) box[k] = k % 2 ? reach : -reach;
        seen = reference_box(w, grids[i], box);
    }
    for (i = 0; i < 24 && seen; i++) {
        double wide[4], side = fmax(box[1] - box[0], box[3] - box[2]);
        int within = 1;
        for (k = 0; k < 4; k++) box[k] = wide[k] = fmin(fmax(box[k] + (k % 2 ? 0.5 : -0.5) * side, -reach), reach);
        if (!reference_box(w, 60, box)) { /* between the grid's points */
            memcpy(box, wide, sizeof wide);
            return 1;
        }
        for (k = 0; k < 4; k++) within &= fabs(wide[k]) >= reach || (k % 2 ? box[k] < wide[k] : box[k] > wide[k]);
        if (within) break;
    }
    return seen;
}

/* A whole ghost at one wavelength. */
static void *reference_mesh(void *user)
{
    reference_worker *w = (reference_worker *)user;
    const reference_desc *d = w->d;
    const lflare_surface *front = &d->lens->prescription.surfaces[0];
    double slope = hypot(d->slope[0], d->slope[1]), reach = front->semi_diameter + fabs(lflare_sag(front, front->semi_diameter)) * slope;
    double box[4], power;
    int n = d->cells, i, j, seen;
    reference_vertex *memory, *above, *row;
    w->path.unweighted = 1;
    seen = reference_entrance(w, reach, box);
    w->path.unweighted = 0;
    if (!seen) return NULL;
    power = (double)d->width * d->height / (4 * d->half[0] * d->half[1] * sqrt(1 + slope * slope)); /* cos theta over a pixel's area */
    memory = (reference_vertex *)calloc((size_t)n + 1, 2 * sizeof *memory);
    if (memory == NULL) { w->failed = 1; return NULL; }
    above = memory;
    row = memory + n + 1;
    for (j = 0; j <= n; j++) {
        reference_vertex *t;
        for (i = 0; i <= n; i++) row[i] = reference_trace(w, box[0] + (box[1] - box[0]) * i / n, box[2] + (box[3] - box[2]) * j / n);
        for (i = 0; i < n && j > 0; i++) {
            reference_vertex cell[4];
            cell[0] = above[i], cell[1] = above[i + 1], cell[2] = row[i + 1], cell[3] = row[i];
            reference_cell(w, cell, power, REFERENCE_DEPTH);
        }
        t = above, above = row, row = t;
        if (d->stop != NULL && *d->stop) break;
    }
    free(memory);
    return NULL;
}

/* ---- the picture ---- */

/* Adds a job's picture to the sum, and empties it. */
static void reference_collect(reference_worker *w, const double *rgb, double *sum)
{
    int x, y, k;
    for (y = w->rows[0]; y <= w->rows[1]; y++) {
        double *row = w->steps + (size_t)y * (size_t)(w->d->width + 2), *out = sum + (size_t)3 * (size_t)y * (size_t)w->d->width, value = 0;
        for (x = 0; x < w->d->width; x++, out += 3) {
            value += row[x];
            for (k = 0; k < 3; k++) out[k] += value * rgb[k];
        }
        memset(row, 0, sizeof *row * (size_t)(w->d->width + 2));
    }
    w->rows[0] = w->d->height;
    w->rows[1] = -1;
}

/* One job a worker, at once. */
static void reference_round(reference_worker **workers, int count)
{
    int t;
#ifndef _WIN32
    pthread_t ids[REFERENCE_MAX_THREADS];
    int started[REFERENCE_MAX_THREADS];
    for (t = 1; t < count; t++) started[t] = pthread_create(&ids[t], NULL, reference_mesh, workers[t]) == 0;
    reference_mesh(workers[0]);
    for (t = 1; t < count; t++) {
        if (started[t]) pthread_join(ids[t], NULL);
        else reference_mesh(workers[t]);
    }
#else
    for (t = 0; t < count; t++) reference_mesh(workers[t]);
#endif
}

static int reference_stopped(const reference_desc *d) { return d->stop != NULL && *d->stop; }

/* Rounds of as many jobs as there are workers, their pictures added up in the jobs' order: hence the same sums for any number of
   workers, each of which needs only one picture of its own. */
static int reference_jobs(const reference_desc *d, const lflare_pair *pairs, int ghosts, reference_worker **workers, int count, double *sum)
{
    int jobs = ghosts * d->wavelengths, job, t, failed = 0;
    for (job = 0; job < jobs && !failed && !reference_stopped(d); job += count) {
        int now = jobs - job < count ? jobs - job : count;
        for (t = 0; t < now; t++) lflare_path_make(d->lens, d->nm[(job + t) % d->wavelengths], &pairs[(job + t) / d->wavelengths], &workers[t]->path);
        reference_round(workers, now);
        for (t = 0; t < now; t++) {
            reference_collect(workers[t], d->rgb[(job + t) % d->wavelengths], sum);
            failed |= workers[t]->failed;
        }
        if (d->progress != NULL) d->progress(d->user, (double)(job + now) / jobs);
    }
    return failed;
}

static int reference_threads(int asked)
{
#ifndef _WIN32
    if (asked <= 0) asked = (int)sysconf(_SC_NPROCESSORS_ONLN);
#endif
    return asked < 1 ? 1 : asked > REFERENCE_MAX_THREADS ? REFERENCE_MAX_THREADS : asked;
}

static reference_worker *reference_worker_make(const reference_desc *d)
{
    reference_worker *w = (reference_worker *)calloc(1, sizeof *w);
    if (w == NULL) return NULL;
    w->d = d;
    w->rows[0] = d->height;
    w->rows[1] = -1;
    w->steps = (double *)calloc((size_t)d->height, (size_t)(d->width + 2) * sizeof(double));
    if (w->steps != NULL) return w;
    free(w);
    return NULL;
}

/* Fills rgb[3 * width * height], rows from the top, multiples of E. 1 done, 0 stopped, -1 out of memory or a count below 1. Takes
   24 bytes a pixel and 8 more a thread. */
static int reference_render(const reference_desc *d, float *rgb)
{
    size_t values = (size_t)3 * (size_t)d->width * (size_t)d->height, i;
    int32_t count = d->lens->ghost_count;
    lflare_pair *pairs;
    double *sum;
    reference_worker *workers[REFERENCE_MAX_THREADS];
    int threads = reference_threads(d->threads), made = 0, failed;
    if (d->width < 1 || d->height < 1 || d->cells < 1 || d->wavelengths < 1 || d->wavelengths > REFERENCE_MAX_WAVELENGTHS) return -1;
    pairs = (lflare_pair *)calloc((size_t)count + 1, sizeof *pairs);
    sum = (double *)calloc((size_t)d->height, (size_t)d->width * 3 * sizeof(double));
    failed = pairs == NULL || sum == NULL;
    if (!failed) {
        lflare_ghost_list(d->lens, pairs, &count);
        if (d->only != NULL) pairs[0] = *d->only, count = 1;
        if (threads > count * d->wavelengths) threads = count * d->wavelengths;
        while (made < threads && (workers[made] = reference_worker_make(d)) != NULL) made++;
        failed = made < threads || (made > 0 && reference_jobs(d, pairs, (int)count, workers, made, sum));
        for (i = 0; i < values; i++) rgb[i] = (float)fmax(sum[i], 0);
    }
    while (made-- > 0) {
        free(workers[made]->steps);
        free(workers[made]);
    }
    free(sum);
    free(pairs);
    return failed ? -1 : reference_stopped(d) ? 0 : 1;
}

#endif
