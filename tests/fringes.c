/* make fringes: what is drawn of an iris in a ghost, beside the exact integral: rows of irises, and in each row Fresnel numbers that fall,
   drawn above exact. Writes build/fringes.pgm and prints how far they are apart within 0.9 of the iris and all over, in percent of the
   open iris's light. */
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"
#include <fftw3.h>
#include <stdio.h>
#include "fresnel.h"

enum { SIZE = 320, NUMBERS = 4, IRISES = 4 };

static const double numbers[NUMBERS] = {1000, 200, 50, 12};

static void complain(const char *what)
{
    fprintf(stderr, "fringes: %s\n", what);
    exit(2);
}

/* A heart, in an image whose corners are (-1, -1) and (1, 1). */
static float heart(double x, double y)
{
    double a = 1.25 * x, b = 1.2 * y + 0.1, c = a * a + b * b - 0.75;
    return c * c * c - a * a * b * b * b < 0 ? 1.0f : 0.0f;
}

static lflare_iris make_iris(int which, uint8_t *mask, uint8_t *fringed)
{
    static const int32_t blades[IRISES] = {5, 8, 0, 7};
    static float image[512 * 512];
    lflare_lens *lens = (lflare_lens *)calloc(1, sizeof *lens);
    lflare_mask_desc desc;
    lflare_fringed_job job;
    lflare_iris iris;
    void *work = malloc(LFLARE_FRINGED_WORK_BYTES);
    int i;
    if (lens == NULL || work == NULL) complain("out of memory");
    lens->stop_a11 = 1;
    lens->efl = 2;
    lens->fnumber = 1;
    lens->prescription.surfaces[0].semi_diameter = 1;
    lflare_iris_make(lens, 1, blades[which], 0.2, which == 1 ? 0.5 : 0, &iris, NULL);
    free(lens);
    if (which >= 2) {
        memset(&desc, 0, sizeof desc);
        for (i = 0; i < 512 * 512; i++) image[i] = heart((i % 512 + 0.5) / 256 - 1, 1 - (i / 512 + 0.5) / 256);
        if (which == 2) desc.pixels = image;
        desc.width = desc.height = 512;
        desc.dust_count = which == 3 ? 40 : 0;
        desc.dust_size = 0.03f;
        desc.scratch_count = which == 3 ? 5 : 0;
        desc.scratch_spread = 1.5f;
        desc.seed = 3;
        lflare_mask_rows(&desc, mask, 0, LFLARE_MASK_SIZE);
        if (lflare_iris_set_mask(&iris, mask) != LFLARE_OK || lflare_fringed_begin(mask, fringed, work, &job) != LFLARE_OK) complain("the mask is not taken");
        while (lflare_fringed_step(&job, 100) == LFLARE_INCOMPLETE) {}
        iris.fringed = fringed;
    }
    free(work);
    return iris;
}

int main(void)
{
    static float ringing[LFLARE_RINGING_FLOATS];
    static uint8_t mask[LFLARE_MASK_BYTES], fringed[LFLARE_FRINGED_BYTES], picture[2 * IRISES * SIZE][NUMBERS * SIZE];
    FILE *file = fopen("build/fringes.pgm", "wb");
    int which, number, x, y;
    if (file == NULL) complain("build/fringes.pgm cannot be written");
    lflare_ringing_make(ringing);
    for (which = 0; which < IRISES; which++) {
        lflare_iris iris = make_iris(which, mask, fringed);
        for (number = 0; number < NUMBERS; number++) {
            double ring = 1 / sqrt(2 * numbers[number]), wrong = 0, inside = 0, *exact = fresnel(fresnel_amplitude, &iris, ring);
            int count = 0;
            lflare_footprint fp = fresnel_footprint(ringing, 2.4 / SIZE, ring); /* edges of a pixel */
            for (y = 0; y < SIZE; y++)
                for (x = 0; x < SIZE; x++) {
                    double px = 2.4 * (x + 0.5) / SIZE - 1.2, py = 1.2 - 2.4 * (y + 0.5) / SIZE;
                    double drawn = (double)lflare_footprint_coverage(&fp, 1, &iris, (float)px, (float)py), there = fresnel_at(exact, px, py);
                    wrong += (drawn - there) * (drawn - there);
                    if (px * px + py * py < 0.81 && lflare_iris_transmission(&iris, (float)px, (float)py, 1e-3f) > 0.01f) {
                        inside += (drawn - there) * (drawn - there);
                        count++;
                    }
                    picture[2 * which * SIZE + y][number * SIZE + x] = (uint8_t)(255 * pow(fmin(drawn / 1.8, 1), 1 / 2.2));
                    picture[(2 * which + 1) * SIZE + y][number * SIZE + x] = (uint8_t)(255 * pow(fmin(there / 1.8, 1), 1 / 2.2));
                }
            printf("%-8s Fresnel number %4.0f: rms %4.1f %% within 0.9 radii, %4.1f %% all over\n", which == 0 ? "5 blades" : which == 1 ? "8 curved" : which == 2 ? "heart" : "dusty", numbers[number],
                   100 * sqrt(inside / count), 100 * sqrt(wrong / (SIZE * SIZE)));
            free(exact);
        }
    }
    fprintf(file, "P5\n%d %d\n255\n", NUMBERS * SIZE, 2 * IRISES * SIZE);
    fwrite(picture, sizeof picture, 1, file);
    if (fclose(file) != 0) complain("build/fringes.pgm cannot be written");
    return 0;
}
