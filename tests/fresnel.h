/* What diffraction makes of an iris on its way to a ghost, as exactly as a grid allows: Fresnel's integral by FFTW, over the band of the
   wavelength that a channel stands for (a Gaussian's spread of 5 %), for the tests and for `make fringes`. Needs fftw3.h and lensflare.h's implementation. */
#ifndef LENSFLARE_FRESNEL_H
#define LENSFLARE_FRESNEL_H

enum { FRESNEL_GRID = 2048, FRESNEL_RADII = 8 }; /* samples, and radii of the iris, across */

/* `amplitude` of an iris as the library has it, of lensflare.h. */
static double fresnel_amplitude(const void *iris, double x, double y)
{
    return fabs(x) < 1.01 && fabs(y) < 1.01 ? sqrt((double)lflare_iris_transmission((const lflare_iris *)iris, (float)x, (float)y, 1.0f / 256)) : 0;
}

/* A ghost that is the iris alone, at its own size, in the middle channel; ring 0: plain edges. */
static lflare_footprint fresnel_footprint(const float *ringing, double soft, double ring)
{
    lflare_footprint fp;
    memset(&fp, 0, sizeof fp);
    fp.axis[0] = 1;
    fp.edge_count = 1;
    fp.ringing = ringing;
    fp.edges[0].gain[1] = 1;
    fp.edges[0].soft[1] = (float)soft;
    fp.edges[0].ring[1] = (float)ring;
    return fp;
}

/* The picture's middle FRESNEL_GRID / 4 samples across are the iris. `amplitude` gives that of a point of the iris's plane, in radii;
   `ring` is the length of the fringes in radii, 1 / sqrt(2 x Fresnel number). Returns FRESNEL_GRID^2 powers, to be freed. */
static double *fresnel(double (*amplitude)(const void *user, double x, double y), const void *user, double ring)
{
    enum { N = FRESNEL_GRID, BAND = 3 };
    const size_t cells = (size_t)N * (size_t)N;
    const double pi = 3.14159265358979323846, step = (double)FRESNEL_RADII / N;
    fftw_complex *spectrum = (fftw_complex *)fftw_malloc(sizeof(fftw_complex) * cells), *field = (fftw_complex *)fftw_malloc(sizeof(fftw_complex) * cells);
    double *power = (double *)calloc(cells, sizeof(double)), weights = 0;
    fftw_plan to = fftw_plan_dft_2d(N, N, spectrum, spectrum, FFTW_FORWARD, FFTW_ESTIMATE), from = fftw_plan_dft_2d(N, N, field, field, FFTW_BACKWARD, FFTW_ESTIMATE);
    int i, j, band;
    for (j = 0; j < N; j++)
        for (i = 0; i < N; i++) {
            spectrum[(size_t)j * N + (size_t)i][0] = amplitude(user, (i + 0.5 - N / 2) * step, (j + 0.5 - N / 2) * step);
            spectrum[(size_t)j * N + (size_t)i][1] = 0;
        }
    fftw_execute(to);
    for (band = -BAND; band <= BAND; band++) {
        double x = 2.5 * band / BAND, weight = exp(-0.5 * x * x), length2 = ring * ring * (1 + 0.05 * x); /* half of lambda z over the radius squared */
        for (j = 0; j < N; j++)
            for (i = 0; i < N; i++) {
                double fx = (i < N / 2 ? i : i - N) / (double)FRESNEL_RADII, fy = (j < N / 2 ? j : j - N) / (double)FRESNEL_RADII, f2 = fx * fx + fy * fy;
                double phase = 2 * pi * length2 * f2, gain = fmin(fmax(4 * (FRESNEL_RADII - 2) - 8 * length2 * sqrt(f2), 0), 1) / (double)cells; /* no farther than to the neighbour's iris */
                const double *a = spectrum[(size_t)j * N + (size_t)i];
                double *b = field[(size_t)j * N + (size_t)i];
                b[0] = gain * (a[0] * cos(phase) - a[1] * sin(phase));
                b[1] = gain * (a[0] * sin(phase) + a[1] * cos(phase));
            }
        fftw_execute(from);
        for (i = 0; i < (int)cells; i++) power[i] += weight * (field[i][0] * field[i][0] + field[i][1] * field[i][1]);
        weights += weight;
    }
    for (i = 0; i < (int)cells; i++) power[i] /= weights;
    fftw_destroy_plan(to);
    fftw_destroy_plan(from);
    fftw_free(spectrum);
    fftw_free(field);
    return power;
}

/* Between its samples, linearly; x and y in radii. */
static double fresnel_at(const double *power, double x, double y)
{
    const double step = (double)FRESNEL_RADII / FRESNEL_GRID;
    double fx = x / step + FRESNEL_GRID / 2 - 0.5, fy = y / step + FRESNEL_GRID / 2 - 0.5;
    int ix = (int)floor(fx), iy = (int)floor(fy);
    const double *at = power + (size_t)iy * FRESNEL_GRID + (size_t)ix;
    fx -= ix;
    fy -= iy;
    return (1 - fy) * ((1 - fx) * at[0] + fx * at[1]) + fy * ((1 - fx) * at[FRESNEL_GRID] + fx * at[FRESNEL_GRID + 1]);
}

#endif
